"""`openrois.reason` right before each refusal and failure, over hops too, for applications that use extensions."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from typing import Any

import pytest

from openrois.adapter import Component, OutOfResources, command, parameter, query
from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from tests.support import deployment, wire
from tests.support.deployment import REASON, Adapter, Application
from tests.support.plain import TOY, attached, plain_adapter

COMPLETED = "rois.command.completed"
KETTLE = "kitchen/kettle"


class Kettle(Component, authority="Test", function="actuation"):
    """A kettle that refuses in every way that a component has."""

    volume: int = parameter(100, description="per cent")

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        if changes["volume"] > 100:
            raise ValueError("volume is at most 100")
        return changes

    def __init__(self) -> None:
        super().__init__()
        self.is_on = asyncio.Event()

    @command
    async def start(self) -> None:
        self.is_on.set()
        await asyncio.Event().wait()

    @command
    async def stop(self) -> None: ...

    @command
    async def boil(self, litres: float = 1.0) -> None:
        raise OutOfResources("fill it first:\n\tthere are\x00 0 litres\x1b[31m")

    @command
    async def explode(self) -> None:
        raise ZeroDivisionError("no such valve")

    @command
    async def sulk(self) -> None:
        raise OutOfResources

    @query
    async def temperature(self) -> float:
        raise OutOfResources("the thermometer is in the soup")


@pytest.fixture
async def kettle() -> Kettle:
    return Kettle()


@pytest.fixture
async def kitchen(gateway: Gateway, kettle: Kettle) -> AsyncIterator[Adapter]:
    async with deployment.adapter(gateway, kettle, engine_id="kitchen") as attached_one:
        yield attached_one


@pytest.fixture
async def asking(gateway: Gateway, kitchen: Adapter) -> AsyncIterator[Application]:
    """An application that has said hello and has bound the kettle."""
    async with deployment.application(gateway) as connected:
        await connected.ask("openrois.hello", version="1")
        await connected.ask("rois.command.bind", component_ref=KETTLE)
        yield connected


def unit(command_id: str, command_type: str, *arguments: dict[str, str], ref: str = KETTLE) -> dict[str, Any]:
    return {
        "component_ref": ref,
        "command_type": command_type,
        "command_id": command_id,
        "arguments": list(arguments),
    }


def completed(command_id: str, status: str) -> dict[str, Any]:
    return {"jsonrpc": "2.0", "method": COMPLETED, "params": {"command_id": command_id, "status": status}}


def value(name: str, kind: str, text: str) -> dict[str, str]:
    return {"name": name, "data_type_ref": kind, "value": text}


class TestRefusals:
    async def test_each_says_why(self, asking: Application, gateway: Gateway, subtests: pytest.Subtests) -> None:
        async with deployment.application(gateway) as other:
            await other.ask("openrois.hello", version="1")
            refusals: list[tuple[str, dict[str, Any], str, str]] = [
                ("rois.command.bind", {"component_ref": KETTLE}, "OUT_OF_RESOURCES", "bound by another application"),
                ("rois.command.bind", {"component_ref": "a/b"}, "UNSUPPORTED", "there is no component 'a/b'"),
                ("rois.command.bind_any", {"condition": "x = 'y'"}, "BAD_PARAMETER", "x"),
                ("rois.command.release", {"component_ref": "a/b"}, "UNSUPPORTED", "there is no component 'a/b'"),
                ("rois.command.search", {"condition": "what?"}, "BAD_PARAMETER", ""),
                ("rois.command.get_command_result", {"command_id": "c"}, "BAD_PARAMETER", "no command 'c'"),
                ("rois.command.execute", {"command_unit_list": [unit("c", "start")]}, "OUT_OF_RESOURCES", "first"),
                ("rois.command.execute", {"command_unit_list": [unit("c", "fly")]}, "UNSUPPORTED", "no command 'fly'"),
                ("rois.query.query", {"query_type": "temperature"}, "OUT_OF_RESOURCES", "in the soup"),
                ("rois.event.subscribe", {"event_type": "rain"}, "UNSUPPORTED", "no component"),
                ("rois.event.get_event_detail", {"event_id": "e"}, "BAD_PARAMETER", "'e'"),
                ("rois.system.get_error_detail", {"error_id": "e"}, "BAD_PARAMETER", "there is no error 'e'"),
                ("signaling.restart", {"peer_id": "robot/1"}, "UNSUPPORTED", "there is no such peer connection"),
                ("rois.stream.suspend_stream", {"stream_id": "s"}, "UNSUPPORTED", "there is no stream 's'"),
            ]
            for method, params, code, words in refusals:
                with subtests.test(method=method, code=code):
                    told, reason = await other.why(method, **params)
                    assert told == code
                    assert reason
                    assert words in reason

    async def test_what_is_granted_has_none(self, asking: Application) -> None:
        assert await asking.why("rois.command.search") == ("OK", "")
        assert REASON not in {message.get("method") for message in asking.heard}

    async def test_an_argument_and_a_parameter_that_do_not_fit(self, asking: Application) -> None:
        sequence = [unit("c", "boil", value("litres", "float", "much"))]
        code, reason = await asking.why("rois.command.execute", command_unit_list=sequence)
        assert (code, "litres" in reason) == ("BAD_PARAMETER", True)
        parameters = [value("volume", "int", "loud")]
        code, reason = await asking.why("rois.command.set_parameter", component_ref=KETTLE, parameters=parameters)
        assert (code, "volume" in reason) == ("BAD_PARAMETER", True)

    async def test_what_is_foreign_and_what_does_not_exist_read_the_same(
        self, gateway: Gateway, adapter: Adapter, app: Application, other: Application
    ) -> None:
        await app.ask("openrois.hello", version="1")
        foreign = (await other.ask("rois.stream.connect_stream", component_ref="robot/camera"))["stream_id"]
        reasons = set()
        for stream_id in (foreign, "robot/none"):
            for verb in ("disconnect_stream", "suspend_stream", "query_stream_status"):
                code, reason = await app.why(f"rois.stream.{verb}", stream_id=stream_id)
                assert code == "UNSUPPORTED"
                reasons.add(reason.replace(stream_id, "S"))
        assert reasons == {"there is no stream 'S'"}

    async def test_the_id_is_the_request_s_own(self, asking: Application) -> None:
        for request_id in (7, -1, 1.5, 2**80, "", "日本", "\ud83d", "x" * 5000):
            params = {"component_ref": "a/b"}
            raw = {"jsonrpc": "2.0", "id": request_id, "method": "rois.command.bind", "params": params}
            await asking.send(raw)
            told, reply = await asking.hear(), await asking.hear()
            assert told["params"] == {"request_id": request_id, "reason": "there is no component 'a/b'"}
            assert reply == {"jsonrpc": "2.0", "id": request_id, "result": {"return_code": "UNSUPPORTED"}}

    async def test_a_request_without_an_id_of_its_own_has_none(self, asking: Application) -> None:
        params = {"component_ref": "a/b"}
        await asking.send({"jsonrpc": "2.0", "id": None, "method": "rois.command.bind", "params": params})
        assert (await asking.hear())["result"] == {"return_code": "UNSUPPORTED"}

    async def test_many_at_once_each_right_before_its_reply(self, asking: Application) -> None:
        slow = [await asking.begin("rois.query.query", query_type="temperature") for _ in range(128)]
        fast = [await asking.begin("rois.command.bind", component_ref=f"a/{number}") for number in range(128)]
        for request_id in (*slow, *fast):
            await asking.answer(request_id)
        # That each stood right before its reply is checked as it is heard.
        assert {asking.reasons[request_id] for request_id in slow} == {"the thermometer is in the soup"}
        assert [asking.reasons[request_id] for request_id in fast] == [
            f"there is no component 'a/{number}'" for number in range(128)
        ]


class TestFailures:
    async def run(self, app: Application, *units: dict[str, Any]) -> dict[str, str]:
        assert await app.code("rois.command.execute", command_unit_list=list(units)) == "OK"
        return await app.completed(*(each["command_id"] for each in units))

    async def test_what_the_component_raises_is_read_by_the_application(self, asking: Application) -> None:
        assert await self.run(asking, unit("c", "boil")) == {"c": "OUT_OF_RESOURCES"}
        assert asking.reasons == {"c": "fill it first: there are 0 litres [31m"}

    async def test_a_bug_is_told_without_a_traceback(self, asking: Application) -> None:
        assert await self.run(asking, unit("c", "explode")) == {"c": "ERROR"}
        assert asking.reasons == {"c": "kettle: explode failed: no such valve"}

    async def test_an_adapter_that_gives_no_reason(self, asking: Application) -> None:
        assert await self.run(asking, unit("c", "sulk")) == {"c": "OUT_OF_RESOURCES"}
        assert asking.reasons == {"c": "its adapter gives no reason, but its log may"}

    async def test_what_follows_a_failure(self, asking: Application) -> None:
        assert await self.run(asking, unit("a", "boil"), unit("b", "boil"), unit("c", "stop")) == {
            "a": "OUT_OF_RESOURCES",
            "b": "ABORT",
            "c": "ABORT",
        }
        follows = "an earlier command of the sequence ended OUT_OF_RESOURCES"
        assert (asking.reasons["b"], asking.reasons["c"]) == (follows, follows)

    async def test_a_command_that_is_stopped(self, asking: Application) -> None:
        await asking.ask("rois.command.execute", command_unit_list=[unit("a", "start")])
        await asking.ask("rois.command.execute", command_unit_list=[unit("b", "stop")])
        assert await asking.completed("a", "b") == {"a": "ABORT", "b": "OK"}
        assert asking.reasons == {"a": "kettle was stopped"}

    async def test_a_parameter_that_the_component_refuses(self, asking: Application) -> None:
        parameters = [value("volume", "int", "8000")]
        set_it = await asking.ask("rois.command.set_parameter", component_ref=KETTLE, parameters=parameters)
        command_id = set_it["command_id"]
        assert await asking.completed(command_id) == {command_id: "ERROR"}
        assert asking.reasons == {command_id: "volume is at most 100"}

    async def test_many_at_once(self, asking: Application) -> None:
        begun = [
            await asking.begin("rois.command.execute", command_unit_list=[unit(f"c{number}", "boil")])
            for number in range(256)
        ]
        for request_id in begun:
            await asking.answer(request_id)
        ended = await asking.completed(*(f"c{number}" for number in range(256)))
        assert set(ended.values()) == {"OUT_OF_RESOURCES"}
        assert len(asking.reasons) == 256

    async def test_an_adapter_that_is_gone(self, asking: Application, kitchen: Adapter, kettle: Kettle) -> None:
        await asking.ask("rois.command.execute", command_unit_list=[unit("c", "start")])
        async with deployment.patience():
            await kettle.is_on.wait()
        await kitchen.stop()
        assert await asking.completed("c") == {"c": "ERROR"}
        assert "the engine" in asking.reasons["c"]


class TestHops:
    async def test_a_reason_comes_through_an_engine_in_between(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        below = await stack.enter_async_context(
            wire.engine_over(LocalRegistry("kitchen", [Kettle()]), engine_id="kitchen")
        )
        floor = await stack.enter_async_context(deployment.adapter(gateway, engine_id="floor"))
        await floor.host.engine.attach(await stack.enter_async_context(wire.proxied(below)))
        await attached(gateway, "kitchen")
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.ask("openrois.hello", version="1")
        await app.ask("rois.command.bind", component_ref=KETTLE)
        assert await app.why("rois.query.query", query_type="temperature") == (
            "OUT_OF_RESOURCES",
            "the thermometer is in the soup",
        )
        await app.ask("rois.command.execute", command_unit_list=[unit("c", "boil")])
        assert await app.completed("c") == {"c": "OUT_OF_RESOURCES"}
        assert app.reasons["c"] == "fill it first: there are 0 litres [31m"

    async def test_an_adapter_of_the_base_alone(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        adapter = await stack.enter_async_context(
            plain_adapter(gateway, query__query={"return_code": "ERROR"}, command__execute=None)
        )
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.ask("openrois.hello", version="1")
        assert await app.why("rois.query.query", query_type="mood") == (
            "ERROR",
            "the engine answered rois.query.query with ERROR",
        )
        await app.ask("rois.command.execute", command_unit_list=[unit("c", "start", ref=TOY)])
        request = await adapter.unanswered.get()
        await adapter.answer(request, return_code="OK")
        await adapter.tell_completed(request["params"]["command_unit_list"][0]["command_id"], "ABORT")
        assert await app.completed("c") == {"c": "ABORT"}
        assert app.reasons["c"] == "its adapter gives no reason, but its log may"


class TestBaseAlone:
    async def test_without_hello_only_frames_of_the_base_wire_are_sent(
        self, gateway: Gateway, kitchen: Adapter
    ) -> None:
        async with deployment.application(gateway) as app:
            await app.ask("rois.command.bind", component_ref=KETTLE)
            await app.ask("rois.query.query", query_type="temperature")
            await app.ask("rois.command.bind", component_ref="a/b")
            sequence = [unit("a", "boil"), unit("b", "boil")]
            await app.ask("rois.command.execute", command_unit_list=sequence)
            await app.completed("a", "b")
            assert [json.dumps({**message, "id": 0} if "id" in message else message) for message in app.heard] == [
                json.dumps(frame)
                for frame in (
                    {"jsonrpc": "2.0", "id": 0, "result": {"return_code": "OK"}},
                    {"jsonrpc": "2.0", "id": 0, "result": {"return_code": "OUT_OF_RESOURCES", "results": []}},
                    {"jsonrpc": "2.0", "id": 0, "result": {"return_code": "UNSUPPORTED"}},
                    {"jsonrpc": "2.0", "id": 0, "result": {"return_code": "OK"}},
                    completed("a", "OUT_OF_RESOURCES"),
                    completed("b", "ABORT"),
                )
            ]
