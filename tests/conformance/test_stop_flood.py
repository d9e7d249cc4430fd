"""However many stops and binds are requested at once, the adapter keeps its connection and all are answered."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from dataclasses import dataclass, field
from typing import Any, Final

import pytest

from openrois.adapter import Component, command
from openrois.aio.tasks import TaskScope
from openrois.commands import stop
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.jsonrpc.outbox import CONTROL_LIMIT
from openrois.session.session import EngineHost
from openrois.transport.memory import MemoryStream
from openrois.transport.stream import MessageStream
from tests.support.wire import Application, adapter_leg, application, hosted

LIMBS: Final = 120
FLOOD: Final = 256
BINDS: Final = CONTROL_LIMIT + 100


class Limb(Component, authority="Test", function="actuation"):
    """Moves until it is stopped, and counts."""

    def __init__(self, name: str, pauses: int) -> None:
        super().__init__(name)
        self.stops = 0
        self.moving = asyncio.Event()
        self._pauses = pauses

    @command
    async def start(self) -> None:
        self.moving.set()
        try:
            await asyncio.Event().wait()
        finally:
            self.moving.clear()

    @command
    async def stop(self) -> None:
        self.stops += 1
        for _ in range(self._pauses):
            await asyncio.sleep(0)


class Sense(Component, authority="Test", function="sensing"):
    """A sensing component, which needs no lease."""

    @command
    async def stop(self) -> None: ...


@dataclass
class Scene:
    """A gateway and an adapter that reads only while it may."""

    host: EngineHost
    limbs: tuple[Limb, ...]
    reads: asyncio.Event = field(default_factory=asyncio.Event)
    adapter: MessageStream | None = None

    @property
    def is_connected(self) -> bool:
        return "robot/0" in self.host.engine.directory.component_profiles


@pytest.fixture(params=[0, 100], ids=["at-once", "slowly"])
async def scene(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Scene]:
    # How long a machine takes for all this is not what it is about.
    monkeypatch.setattr(stop, "STOP_TIMEOUT", 60.0)
    limbs = tuple(Limb(str(number), request.param) for number in range(LIMBS))
    robot = Engine("robot")
    await robot.attach(LocalRegistry("robot", (*limbs, Sense("sense"))))
    async with AsyncExitStack() as stack:
        host = EngineHost(Engine("gateway"), await stack.enter_async_context(TaskScope()))
        made = Scene(host, limbs)
        below = await stack.enter_async_context(hosted(robot))
        receive = MemoryStream.receive

        async def dawdle(stream: MemoryStream) -> str:
            text = await receive(stream)
            if stream is made.adapter:
                await made.reads.wait()
            return text

        monkeypatch.setattr(MemoryStream, "receive", dawdle)
        made.adapter = await stack.enter_async_context(adapter_leg(host, below))
        made.reads.set()
        yield made
        made.reads.set()


QUICK_TO_STOP: Final = pytest.mark.parametrize("scene", [0], indirect=True, ids=["at-once"])
"""For what is not about how long a stop takes."""


async def settled() -> None:
    """Let everything run that can: no task waits for a clock here."""
    for _ in range(500):
        await asyncio.sleep(0)


def execute(app: Application, *units: tuple[str, str, str]) -> None:
    items = [
        {"component_ref": ref, "command_type": command_type, "command_id": command_id}
        for ref, command_type, command_id in units
    ]
    app.session.post("rois.command.execute", {"command_unit_list": [{"command_list": items}]})


async def ended(app: Application, count: int) -> dict[str, str]:
    told = [await app.next("rois.command.completed") for _ in range(count)]
    return {each["command_id"]: each["status"] for each in told}


async def test_every_one_of_a_flood_is_told_that_all_have_stopped(scene: Scene) -> None:
    loop = asyncio.get_running_loop()
    async with application(scene.host) as app:
        scene.reads.clear()
        began = loop.time()
        asked = [asyncio.ensure_future(app.ask("openrois.stop_all")) for _ in range(FLOOD - 1)]
        await settled()
        assert all(limb.stops <= 1 for limb in scene.limbs)
        before = [limb.stops for limb in scene.limbs]
        asked.append(asyncio.ensure_future(app.ask("openrois.stop_all")))
        await settled()
        scene.reads.set()
        answers: list[dict[str, Any]] = await asyncio.gather(*asked)
        assert {answer["return_code"] for answer in answers} == {"OK"}
        assert {len(answer["stopped"]) for answer in answers} == {LIMBS}
        assert scene.is_connected
        # On a busy machine so much time passes that components which still stop get another `stop`.
        most = 3 + (loop.time() - began) / stop.PAUSE
        assert all(after < limb.stops <= most for after, limb in zip(before, scene.limbs, strict=True))


async def test_a_flood_of_executed_stops(scene: Scene) -> None:
    async with AsyncExitStack() as stack:
        apps = [await stack.enter_async_context(application(scene.host)) for _ in range(5)]
        scene.reads.clear()
        for number in range(16):
            for app in apps:
                execute(app, *(("robot/sense", "stop", f"{number}.{each}") for each in range(64)))
        await settled()
        scene.reads.set()
        for app in apps:
            assert set((await ended(app, 16 * 64)).values()) == {"OK"}
        assert scene.is_connected


@QUICK_TO_STOP
async def test_binding_again_and_again(scene: Scene) -> None:
    async with application(scene.host) as app:
        scene.reads.clear()
        for _ in range(BINDS):
            assert (await app.ask("rois.command.bind", component_ref="robot/0"))["return_code"] == "OK"
        assert scene.is_connected
        scene.reads.set()
        assert (await app.ask("openrois.stop_all"))["return_code"] == "OK"


@QUICK_TO_STOP
async def test_binding_and_giving_back_in_turns(scene: Scene) -> None:
    lamp = {"component_ref": "robot/0"}
    ways: tuple[tuple[str, dict[str, str]], ...] = (("rois.command.release", lamp), ("rois.system.disconnect", {}))
    async with application(scene.host) as app:
        scene.reads.clear()
        for way, params in (*ways * (BINDS // 4), ways[0]):
            assert (await app.ask("rois.command.bind", **lamp))["return_code"] == "OK"
            assert (await app.ask(way, **params))["return_code"] == "OK"
        assert (await app.ask("rois.command.bind", **lamp))["return_code"] == "OK"
        assert scene.is_connected
        scene.reads.set()
        assert (await app.ask("openrois.stop_all"))["return_code"] == "OK"


async def test_what_is_asked_between_two_stops_is_stopped_by_the_second_and_what_is_asked_behind_it_runs(
    scene: Scene,
) -> None:
    limb, ref = scene.limbs[0], "robot/0"
    async with application(scene.host) as app:
        await app.ask("rois.command.bind", component_ref=ref)
        scene.reads.clear()
        for command_type, command_id in (("stop", "a"), ("start", "b"), ("stop", "c"), ("stop", "d"), ("start", "e")):
            execute(app, (ref, command_type, command_id))
            await settled()
        scene.reads.set()
        assert await ended(app, 4) == {"a": "OK", "b": "ABORT", "c": "OK", "d": "OK"}
        await limb.moving.wait()
        execute(app, (ref, "stop", "f"))
        assert await ended(app, 2) == {"e": "ABORT", "f": "OK"}
