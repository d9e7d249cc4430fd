"""The latch of STOP lives with the body: the adapter keeps it, and whichever gateway it comes to latches at once."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import pytest

from openrois.adapter.running import hosted
from openrois.aio.tasks import TaskScope
from openrois.auth.principal import Principal
from openrois.component.component import Component
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.gateway.adapters import serve_adapter
from openrois.remote.serve import serve_engine
from openrois.session.session import EngineHost
from openrois.transport.memory import MemoryStream, memory_pair
from openrois.types.stops import StoppedNotification
from tests.support.authorization import Place, Wire, principal
from tests.support.components import Lamp, Rover
from tests.support.wire import no_wait

LAMP = {"component_ref": "robot/lamp"}
ROBOT = {"engine_id": "robot"}
ANN = principal("operator", "*", subject="ann", rank="person")
AGENT = principal("operator", "*", subject="agent", rank="agent")


@asynccontextmanager
async def gateway() -> AsyncIterator[Place]:
    """Run a gateway."""
    async with TaskScope() as tasks:
        yield Place(EngineHost(Engine("gateway"), tasks), {})


@asynccontextmanager
async def attached(place: Place, adapter: EngineHost) -> AsyncIterator[None]:
    """Connect an adapter to a gateway while the block runs."""
    changed = asyncio.Event()
    stop_listening = place.host.engine.on_change(changed.set)
    near, far = memory_pair()
    serving = {
        asyncio.ensure_future(serve_adapter(place.host, near)),
        asyncio.ensure_future(serve_engine(adapter, far)),
    }
    try:
        async with asyncio.timeout(30):
            await changed.wait()
        stop_listening()
        yield
    finally:
        await far.close()
        await asyncio.wait(serving, timeout=30)


@asynccontextmanager
async def application(place: Place, who: Principal) -> AsyncIterator[Wire]:
    async with place.application(who) as app:
        assert await app.code("openrois.hello", {"version": "1", "extensions": ["openrois.lease"]}) == "OK"
        yield app


async def run(app: Wire, command_id: str, ref: str = "robot/lamp", command_type: str = "switch") -> str:
    """Run a command; return how it was refused, or how it ended."""
    unit = {"component_ref": ref, "command_type": command_type, "command_id": command_id, "arguments": []}
    code = str(await app.code("rois.command.execute", {"command_unit_list": [unit]}))
    return await app.completed(command_id) if code == "OK" else code


async def known_there(place: Place, adapter: EngineHost, by: str) -> None:
    """Wait until an adapter keeps what its gateway says: notifications are in order with queries."""
    async with application(place, AGENT) as app:
        condition = {"query_type": "brightness", "condition": "component_ref = 'robot/lamp'"}
        assert await app.code("rois.query.query", condition) == "OK"
    assert adapter.stop_latch.by("robot") == by


@asynccontextmanager
async def standing(*components: Component) -> AsyncIterator[tuple[Place, EngineHost, Wire, Wire]]:
    """Run a gateway with an adapter, a person and a program."""
    async with (
        hosted("robot", *components) as adapter,
        gateway() as here,
        attached(here, adapter),
        application(here, ANN) as ann,
        application(here, AGENT) as agent,
    ):
        yield here, adapter, ann, agent


async def test_a_program_that_tries_hundreds_of_times_reaches_no_component() -> None:
    lamp = Lamp()
    async with standing(lamp) as (_, adapter, ann, agent):
        assert await agent.code("rois.command.bind", LAMP) == "OK"
        assert await run(agent, "before") == "OK"
        assert await ann.code("openrois.stop_all", ROBOT) == "OK"
        reached: list[str] = []
        adapter.engine.invoke = lambda *said: reached.append(said[1])  # type: ignore[assignment, method-assign]
        for number in range(500):
            assert await run(agent, f"try {number}") == "OUT_OF_RESOURCES"
        assert (reached, lamp.total) == ([], 1)
        del adapter.engine.invoke
        assert await ann.code("openrois.lease.release_stop", ROBOT) == "OK"
        assert await run(agent, "after") == "OK"
        assert lamp.total == 2


async def test_what_moves_stops_and_moves_again_when_it_is_handed_back() -> None:
    rover, ref = Rover(), "robot/rover"
    async with standing(Lamp(), rover) as (_, _, ann, agent):
        unit = {"component_ref": ref, "command_type": "start", "command_id": "1", "arguments": []}
        assert await agent.code("rois.command.bind", {"component_ref": ref}) == "OK"
        assert await agent.code("rois.command.execute", {"command_unit_list": [unit]}) == "OK"
        await rover.driving.wait()
        assert await ann.code("openrois.stop_all", ROBOT) == "OK"
        assert await agent.completed("1") == "ABORT"
        assert rover.stopped.is_set()
        rover.driving.clear()
        assert await run(agent, "2", ref, "start") == "OUT_OF_RESOURCES"
        assert await ann.code("openrois.lease.release_stop", ROBOT) == "OK"
        assert await agent.code("rois.command.execute", {"command_unit_list": [{**unit, "command_id": "3"}]}) == "OK"
        await rover.driving.wait()


async def test_a_gateway_that_was_restarted_knows_it_at_once() -> None:
    lamp = Lamp()
    async with hosted("robot", lamp) as adapter:
        async with gateway() as former, attached(former, adapter), application(former, ANN) as ann:
            assert await ann.code("openrois.stop_all", ROBOT) == "OK"
            await known_there(former, adapter, "ann")
        async with gateway() as here, attached(here, adapter), application(here, AGENT) as agent:
            assert await agent.code("rois.command.bind", LAMP) == "OK"
            assert (await agent.result("openrois.lease.query", LAMP))["lease"]["stopped_by"] == "ann"
            assert await run(agent, "1") == "OUT_OF_RESOURCES"
            async with application(here, ANN) as ann:
                assert await ann.code("openrois.lease.release_stop", ROBOT) == "OK"
            assert await run(agent, "2") == "OK"
            await known_there(here, adapter, "")
        async with gateway() as next_one, attached(next_one, adapter), application(next_one, AGENT) as agent:
            assert await agent.code("rois.command.bind", LAMP) == "OK"
            assert await run(agent, "3") == "OK"
    assert lamp.total == 2


async def test_what_was_handed_back_elsewhere_is_handed_back() -> None:
    async with hosted("robot", Lamp()) as adapter, gateway() as one, gateway() as other:
        async with attached(one, adapter), application(one, ANN) as ann:
            assert await ann.code("openrois.stop_all", ROBOT) == "OK"
            await known_there(one, adapter, "ann")
        assert one.host.stop_latch.by("robot") == "ann"
        async with attached(other, adapter), application(other, ANN) as ann:
            assert await ann.code("openrois.lease.release_stop", ROBOT) == "OK"
            await known_there(other, adapter, "")
        async with attached(one, adapter):
            assert one.host.stop_latch.by("robot") == ""


async def test_an_adapter_that_was_restarted_is_told_again() -> None:
    async with gateway() as here:
        async with hosted("robot", Lamp()) as former, attached(here, former), application(here, ANN) as ann:
            assert await ann.code("openrois.stop_all", ROBOT) == "OK"
        async with hosted("robot", Lamp()) as adapter, attached(here, adapter), application(here, AGENT) as agent:
            assert await agent.code("rois.command.bind", LAMP) == "OK"
            assert await run(agent, "1") == "OUT_OF_RESOURCES"
            await known_there(here, adapter, "ann")


async def test_it_goes_over_gateways_that_are_adapters_of_others() -> None:
    lamp = Lamp()
    async with hosted("robot", lamp) as adapter, AsyncExitStack() as stack:
        tasks = await stack.enter_async_context(TaskScope())
        inner = Place(EngineHost(Engine("inner"), tasks, sleep=no_wait), {})
        async with attached(inner, adapter):
            async with gateway() as outer, attached(outer, inner.host), application(outer, ANN) as ann:
                assert await ann.code("openrois.stop_all", ROBOT) == "OK"
                await known_there(outer, adapter, "ann")
                assert inner.host.stop_latch.by("robot") == "ann"
            # The programs of the gateway between wait, too, and the next outer one knows it.
            async with application(inner, AGENT) as agent:
                assert await agent.code("rois.command.bind", LAMP) == "OK"
                assert await run(agent, "1") == "OUT_OF_RESOURCES"
            async with gateway() as outer, attached(outer, inner.host), application(outer, ANN) as ann:
                assert outer.host.stop_latch.by("robot") == "ann"
                assert await ann.code("openrois.lease.release_stop", LAMP) == "OK"
                await known_there(outer, adapter, "")
    assert lamp.total == 0


async def test_a_stop_at_the_gateway_below_holds_for_programs_of_the_one_above() -> None:
    lamp = Lamp()
    async with hosted("robot", lamp) as adapter, AsyncExitStack() as stack:
        tasks = await stack.enter_async_context(TaskScope())
        inner = Place(EngineHost(Engine("inner"), tasks, sleep=no_wait), {})
        await stack.enter_async_context(attached(inner, adapter))
        outer = await stack.enter_async_context(gateway())
        await stack.enter_async_context(attached(outer, inner.host))
        ann = await stack.enter_async_context(application(inner, ANN))
        agent = await stack.enter_async_context(application(outer, AGENT))
        assert await agent.code("rois.command.bind", LAMP) == "OK"
        assert await ann.code("openrois.stop_all", ROBOT) == "OK"
        assert (await agent.until("openrois.lease.stopped"))["by"] == "ann"
        assert await ann.code("openrois.stop_all", ROBOT) == "OK"
        assert (await agent.until("openrois.lease.stopped"))["by"] == "ann"
        assert await run(agent, "1") == "OUT_OF_RESOURCES"
        # Handed back above, it is handed back below.
        async with application(outer, principal("operator", "*", subject="bob", rank="person")) as bob:
            assert await bob.code("openrois.lease.release_stop", ROBOT) == "OK"
        assert await run(agent, "2") == "OK"
        assert await ann.code("openrois.stop_all", ROBOT) == "OK"
        assert await ann.code("openrois.lease.release_stop", ROBOT) == "OK"
        for by in ("ann", ""):
            assert (await agent.until("openrois.lease.stopped"))["by"] == by
        assert await run(agent, "3") == "OK"
    assert lamp.total == 2


async def test_what_an_adapter_says_of_engines_that_are_not_its_own_is_passed_over() -> None:
    async with standing(Lamp()) as (here, adapter, _, agent):
        assert await agent.code("rois.command.bind", LAMP) == "OK"
        adapter.stops.changes.notify_all(StoppedNotification(engine_id="gateway", by="eve"))
        adapter.stops.changes.notify_all(StoppedNotification(engine_id="robot", by="ann"))
        assert (await agent.until("openrois.lease.stopped"))["by"] == "ann"
        assert here.host.stop_latch.by("gateway") == ""


async def test_an_adapter_that_greets_late_is_believed_then(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois.remote.remote_offer.HELLO_TIMEOUT", 0.01)
    near, far = memory_pair()
    async with gateway() as here, asyncio.TaskGroup() as tasks, application(here, AGENT) as agent:
        adapter = OtherAdapter(far, ["openrois.lease", "openrois.lease.stopped"])
        adapter.stopped, adapter.may_greet = [{"engine_id": "robot", "by": "ann"}], asyncio.Event()
        serving = tasks.create_task(serve_adapter(here.host, near))
        answering = tasks.create_task(adapter.run())
        await agent.until("rois.system.profile_changed")
        assert await agent.code("rois.command.bind", LAMP) == "OK"
        assert (await agent.result("openrois.lease.query", LAMP))["lease"]["stopped_by"] == ""
        adapter.may_greet.set()
        assert (await agent.until("openrois.lease.stopped"))["by"] == "ann"
        assert await run(agent, "1") == "OUT_OF_RESOURCES"
        answering.cancel()
        await near.close()
        await serving


class OtherAdapter:
    """An adapter of other code: it speaks the base wire, or extensions of some release.

    Attributes:
        heard: the methods of the notifications that it got.
        stopped: what it says in its hello of its engines.
        may_greet: when it may answer the hello; None for at once.
    """

    def __init__(self, stream: MemoryStream, extensions: list[str] | None) -> None:
        self.heard: list[str] = []
        self.stopped: list[dict[str, str]] = []
        self.may_greet: asyncio.Event | None = None
        self._stream = stream
        self._extensions = extensions
        self._late: list[asyncio.Future[None]] = []

    async def _greet(self, request_id: int, answer: dict[str, Any]) -> None:
        assert self.may_greet is not None
        await self.may_greet.wait()
        await self._stream.send(json.dumps({"jsonrpc": "2.0", "id": request_id, **answer}))

    async def run(self) -> None:
        while True:
            message = json.loads(await self._stream.receive())
            if "id" not in message:
                self.heard.append(message["method"])
                continue
            answer: dict[str, Any] = {"result": {"return_code": "OK"}}
            if message["method"] == "rois.system.get_profile":
                offer = await LocalRegistry("robot", (Lamp(),)).discover()
                profiles = {ref: each.model_dump(mode="json") for ref, each in offer.component_profiles.items()}
                answer["result"] |= {"profile": offer.profile.model_dump(mode="json"), "component_profiles": profiles}
            elif message["method"] == "openrois.hello" and self._extensions is None:
                answer = {"error": {"code": -32601, "message": "no such method"}}
            elif message["method"] == "openrois.hello":
                answer["result"] |= {"version": "1", "extensions": self._extensions, "stopped": self.stopped}
                if self.may_greet is not None:
                    self._late.append(asyncio.ensure_future(self._greet(message["id"], answer)))
                    continue
            await self._stream.send(json.dumps({"jsonrpc": "2.0", "id": message["id"], **answer}))


@pytest.mark.parametrize("extensions", [None, ["openrois.lease"]], ids=["base wire", "older"])
async def test_an_adapter_that_keeps_no_latch_is_left_alone(extensions: list[str] | None) -> None:
    async with gateway() as here, asyncio.TaskGroup() as tasks:
        for times in range(2):
            near, far = memory_pair()
            adapter, changed = OtherAdapter(far, extensions), asyncio.Event()
            stop_listening = here.host.engine.on_change(changed.set)
            serving = tasks.create_task(serve_adapter(here.host, near))
            answering = tasks.create_task(adapter.run())
            await changed.wait()
            stop_listening()
            async with application(here, ANN) as ann, application(here, AGENT) as agent:
                if not times:
                    assert await ann.code("openrois.stop_all", ROBOT) in ("OK", "ERROR")
                # The gateway keeps it for as long as it lives.
                assert await agent.code("rois.command.bind", LAMP) == "OK"
                assert await run(agent, f"{times}") == "OUT_OF_RESOURCES"
            answering.cancel()
            await near.close()
            await serving
            assert "openrois.lease.stopped" not in adapter.heard
