"""notify_error and get_error_detail: which applications are notified of a fault, and may read its details."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from typing import Any

import pytest

from openrois.component.authoring.marks import command
from openrois.component.component import Component
from openrois.contract import Fault
from openrois.engine.engine import Engine
from openrois.engine.faults import FAULTS_AT_ONCE
from openrois.engine.registry import LocalRegistry
from openrois.gateway.server import Gateway
from openrois.session.error_log import MAX_ERRORS
from openrois.types.codes import ErrorType
from openrois.types.values import check_value
from tests.support import deployment, wire
from tests.support.deployment import Adapter, Application, Door, Robot
from tests.support.plain import TOY, PlainAdapter, attached, component_profile, plain_adapter, profile_result
from tests.support.viewer import CAMERA, stream_of

LAMP, BELL, DOOR = "robot/lamp", "robot/bell", "robot/door"
NO_DETAILS = {"return_code": "BAD_PARAMETER", "results": []}


async def execute(app: Application, component_ref: str, command_type: str, command_id: str = "c") -> str:
    unit = {"component_ref": component_ref, "command_type": command_type, "command_id": command_id}
    return await app.code("rois.command.execute", command_unit_list=[unit])


async def details(app: Application, error_id: str) -> dict[str, str]:
    """Return the results of get_error_detail by name, each of the type it says."""
    answer = await app.ask("rois.system.get_error_detail", error_id=error_id)
    assert answer["return_code"] == "OK"
    for result in answer["results"]:
        check_value(result["data_type_ref"], result["value"])
    return {result["name"]: result["value"] for result in answer["results"]}


class Noticed:
    """All faults that the gateway has got."""

    def __init__(self, gateway: Gateway) -> None:
        self._faults: asyncio.Queue[Fault] = asyncio.Queue()
        gateway.engine.faults.add(self._note)

    def _note(self, faults: tuple[Fault, ...]) -> None:
        for fault in faults:
            self._faults.put_nowait(fault)

    async def next(self) -> Fault:
        async with deployment.patience():
            return await self._faults.get()


@pytest.fixture
async def noticed(gateway: Gateway) -> Noticed:
    return Noticed(gateway)


class TestComponents:
    async def test_a_component_that_raises(self, app: Application, other: Application) -> None:
        await app.code("rois.command.bind", component_ref=LAMP)
        await execute(app, LAMP, "crash")
        assert await app.completed("c") == {"c": "ERROR"}
        told = await app.next("rois.system.notify_error")
        assert told["error_type"] == "COMPONENT_INTERNAL_ERROR"
        assert told["error_id"].startswith("robot/")
        found = await details(app, told["error_id"])
        assert found.pop("timestamp").endswith("+00:00")
        assert found == {
            "component_ref": LAMP,
            "error_type": "COMPONENT_INTERNAL_ERROR",
            "description": "lamp: crash failed: a bug",
        }
        assert await other.settled() == []
        assert await other.ask("rois.system.get_error_detail", error_id=told["error_id"]) == NO_DETAILS

    async def test_the_details_of_nothing(self, app: Application, robot: Robot) -> None:
        await app.code("rois.command.bind", component_ref=BELL)
        robot.bell.report(ErrorType.USER_DEFINED_ERROR, "cracked")
        error_id = (await app.next("rois.system.notify_error"))["error_id"]
        for params in (
            {"error_id": ""},
            {"error_id": "robot/1"},
            {"error_id": error_id + "0"},
            {"error_id": error_id, "condition": "component_ref = 'robot/bell'"},
        ):
            assert await app.ask("rois.system.get_error_detail", **params) == NO_DETAILS
        for wrong in ({}, {"error_id": 5}, {"error_id": error_id, "condition": None}, {"error_id": "x", "more": 1}):
            assert (await app.refused("rois.system.get_error_detail", **wrong))["code"] == -32602
        assert (await app.refused("rois.system.notify_error"))["code"] == -32601

    async def test_told_between_bind_and_release(self, app: Application, robot: Robot, noticed: Noticed) -> None:
        """Also where a component needs no reservation."""
        for ref, component in ((LAMP, robot.lamp), (BELL, robot.bell)):
            component.report(ErrorType.USER_DEFINED_ERROR, "before")
            await noticed.next()
            await app.settled()
            await app.code("rois.command.bind", component_ref=ref)
            component.report(ErrorType.USER_DEFINED_ERROR, "now")
            told = await app.next("rois.system.notify_error")
            assert (await details(app, told["error_id"]))["description"] == "now"
            await noticed.next()
            await app.code("rois.command.release", component_ref=ref)
            component.report(ErrorType.USER_DEFINED_ERROR, "after")
            await noticed.next()
            assert await app.settled() == []

    async def test_told_between_subscribe_and_unsubscribe(
        self, app: Application, robot: Robot, noticed: Noticed
    ) -> None:
        subscribed = await app.ask("rois.event.subscribe", event_type="rang", condition=f"component_ref = '{BELL}'")
        robot.bell.report(ErrorType.USER_DEFINED_ERROR, "cracked")
        await noticed.next()
        robot.door.report(ErrorType.USER_DEFINED_ERROR, "squeaks")
        await noticed.next()
        told = await app.next("rois.system.notify_error")
        assert told["error_type"] == "USER_DEFINED_ERROR"
        assert (await details(app, told["error_id"]))["component_ref"] == BELL
        await app.ask("rois.event.unsubscribe", subscribe_id=subscribed["subscribe_id"])
        robot.bell.report(ErrorType.USER_DEFINED_ERROR, "cracked")
        await noticed.next()
        assert await app.settled() == []

    async def test_notified_to_an_application_with_a_command_on_it(
        self, app: Application, other: Application, robot: Robot
    ) -> None:
        robot.door.may_answer.clear()
        await execute(app, DOOR, "open")
        await robot.door.asked.wait()
        robot.door.report(ErrorType.USER_DEFINED_ERROR, "squeaks")
        told = await app.next("rois.system.notify_error")
        assert (await details(app, told["error_id"]))["component_ref"] == DOOR
        robot.door.may_answer.set()
        await app.completed("c")
        assert await other.settled() == []

    async def test_notified_to_an_application_with_a_stream_of_it(
        self, app: Application, other: Application, robot: Robot, noticed: Noticed
    ) -> None:
        stream_id = await stream_of(app)
        robot.camera.report(ErrorType.COMPONENT_NOT_RESPONDING, "it has stood still")
        told = await app.next("rois.system.notify_error")
        assert (await details(app, told["error_id"]))["component_ref"] == CAMERA
        assert await other.settled() == []
        await noticed.next()
        await app.ask("rois.stream.disconnect_stream", stream_id=stream_id)
        await app.settled()
        robot.camera.report(ErrorType.COMPONENT_NOT_RESPONDING, "and still does")
        await noticed.next()
        assert "rois.system.notify_error" not in await app.settled()

    async def test_the_command_that_failed_has_ended_by_then(self, app: Application, robot: Robot) -> None:
        del robot.door.may_answer
        await execute(app, DOOR, "open")
        assert await app.completed("c") == {"c": "ERROR"}
        assert (await app.next("rois.system.notify_error"))["error_type"] == "COMPONENT_INTERNAL_ERROR"

    async def test_the_reply_comes_first(self, app: Application, robot: Robot) -> None:
        await app.code("rois.command.bind", component_ref=DOOR)
        del robot.door.may_answer
        asked = await app.begin("rois.query.query", query_type="view")
        assert (await app.hear())["id"] == asked
        assert (await app.hear())["method"] == "rois.system.notify_error"

    async def test_the_reply_comes_first_of_a_component_in_the_gateway_itself(
        self, gateway: Gateway, stack: AsyncExitStack
    ) -> None:
        door = Door()
        del door.may_answer
        await gateway.engine.attach(LocalRegistry("local", [door]))
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.code("rois.command.bind", component_ref="local/door")
        asked = await app.begin("rois.query.query", query_type="view")
        assert (await app.hear())["id"] == asked
        assert (await app.hear())["method"] == "rois.system.notify_error"

    async def test_told_after_disconnect_no_more(self, app: Application, robot: Robot, noticed: Noticed) -> None:
        await app.code("rois.command.bind", component_ref=BELL)
        await app.code("rois.system.disconnect")
        robot.bell.report(ErrorType.USER_DEFINED_ERROR, "cracked")
        await noticed.next()
        assert await app.settled() == []

    async def test_a_component_that_came_back_is_another(
        self, app: Application, adapter: Adapter, robot: Robot, noticed: Noticed
    ) -> None:
        await app.code("rois.command.bind", component_ref=BELL)
        await adapter.stop()
        await adapter.start()
        robot.bell.report(ErrorType.USER_DEFINED_ERROR, "cracked")
        await noticed.next()
        assert set(await app.settled()) == {"rois.system.profile_changed"}

    async def test_a_flood_is_cut_and_old_errors_are_forgotten(self, app: Application, robot: Robot) -> None:
        await app.code("rois.command.bind", component_ref=BELL)
        for number in range(1000):
            robot.bell.report(ErrorType.USER_DEFINED_ERROR, f"crack {number}")
        ids = [(await app.next("rois.system.notify_error"))["error_id"] for _ in range(FAULTS_AT_ONCE)]
        assert len(set(ids)) == FAULTS_AT_ONCE <= MAX_ERRORS
        assert (await details(app, ids[0]))["description"] == "crack 0"
        assert len(await app.settled()) < 20


class Sluggish(Component, function="sensing"):
    """A command that never ends and may take a millisecond."""

    @command(timeout=0.001)
    async def dawdle(self) -> None:
        await deployment.forever()


class TestNotResponding:
    async def test_a_command_beyond_its_time(self, app: Application, gateway: Gateway, stack: AsyncExitStack) -> None:
        await stack.enter_async_context(deployment.adapter(gateway, Sluggish(), engine_id="second"))
        await execute(app, "second/sluggish", "dawdle")
        assert await app.completed("c") == {"c": "TIMEOUT"}
        told = await app.next("rois.system.notify_error")
        assert told["error_type"] == "COMPONENT_NOT_RESPONDING"
        assert (await details(app, told["error_id"]))["component_ref"] == "second/sluggish"

    async def test_an_engine_that_does_not_answer(
        self, gateway: Gateway, stack: AsyncExitStack, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        sessions = deployment.adapter_sessions(monkeypatch)
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.code("rois.command.bind", component_ref=TOY)
        sessions[0].call_timeout = 0.01
        silent = ("rois.query.query", "rois.command.execute", "rois.command.get_parameter", "rois.event.subscribe")
        plain.answers.update(dict.fromkeys(silent))
        calls: list[tuple[str, dict[str, Any]]] = [
            ("rois.query.query", {"query_type": "mood"}),
            ("rois.event.subscribe", {"event_type": "laughed"}),
            ("rois.command.get_parameter", {"component_ref": TOY}),
        ]
        for method, params in calls:
            assert await app.code(method, **params) == "TIMEOUT"
        await execute(app, TOY, "start")
        assert await app.completed("c") == {"c": "TIMEOUT"}
        for _ in range(4):
            told = await app.next("rois.system.notify_error")
            assert told["error_type"] == "COMPONENT_NOT_RESPONDING"
            assert told["error_id"].startswith(f"{gateway.engine.engine_id}/")
            assert (await details(app, told["error_id"]))["component_ref"] == TOY

    async def test_a_command_that_its_adapter_does_not_end(
        self, gateway: Gateway, stack: AsyncExitStack, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        sessions = deployment.adapter_sessions(monkeypatch)
        profile = profile_result("toy")
        profile["component_profiles"][TOY]["command_profiles"][0]["timeout"] = 10
        plain = await stack.enter_async_context(plain_adapter(gateway, profile))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        plain.answers["rois.command.execute"] = None
        await execute(app, TOY, "start")
        async with deployment.patience():
            request = await plain.unanswered.get()
        sessions[0].call_timeout = 0
        await plain.answer(request, return_code="OK")
        assert await app.completed("c") == {"c": "TIMEOUT"}
        told = await app.next("rois.system.notify_error")
        assert told["error_type"] == "COMPONENT_NOT_RESPONDING"
        await plain.tell_completed(request["params"]["command_unit_list"][0]["command_id"])
        assert await app.settled() == []

    async def test_an_engine_that_does_not_answer_about_a_stream(
        self, gateway: Gateway, robot: Robot, stack: AsyncExitStack, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        sessions = deployment.adapter_sessions(monkeypatch)
        await stack.enter_async_context(deployment.adapter(gateway, robot.camera, extension=robot.streams))
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.code("rois.command.bind", component_ref="robot/camera")
        stream_id = (await app.ask("rois.stream.connect_stream", component_ref="robot/camera"))["stream_id"]
        sessions[0].call_timeout = 0.01
        robot.streams.may_answer.clear()
        assert await app.code("rois.stream.connect_stream", component_ref="robot/camera") == "TIMEOUT"
        assert await app.code("rois.stream.suspend_stream", stream_id=stream_id) == "TIMEOUT"
        for _ in range(2):
            told = await app.next("rois.system.notify_error")
            assert told["error_type"] == "COMPONENT_NOT_RESPONDING"
            assert (await details(app, told["error_id"]))["component_ref"] == "robot/camera"
        robot.streams.may_answer.set()


class TestLostAdapters:
    async def test_its_users_are_notified_and_its_components_count_as_failing(
        self, gateway: Gateway, stack: AsyncExitStack
    ) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        stranger = await stack.enter_async_context(deployment.application(gateway))
        await stranger.code("rois.system.connect")
        await app.code("rois.command.bind", component_ref=TOY)
        plain.hold_completed = True
        await execute(app, TOY, "start")
        plain.socket.transport.abort()
        assert await app.completed("c") == {"c": "ERROR"}
        told = await app.next("rois.system.notify_error")
        assert told["error_type"] == "COMPONENT_NOT_RESPONDING"
        assert (await details(app, told["error_id"]))["component_ref"] == TOY
        await app.next("rois.system.profile_changed")
        assert await app.settled() == []
        assert await stranger.settled() == ["rois.system.profile_changed"]
        status = await app.ask("rois.query.query", query_type="component_status", condition=f"component_ref = '{TOY}'")
        assert [each["value"] for each in status["results"]] == ["ERROR"]
        assert await app.code("rois.command.bind", component_ref=TOY) == "UNSUPPORTED"
        await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        mood = {"query_type": "component_status", "condition": f"component_ref = '{TOY}'"}
        assert await app.code("rois.query.query", **mood) == "UNSUPPORTED"
        assert await app.code("rois.command.bind", component_ref=TOY) == "OK"

    async def test_one_that_takes_its_leave_is_no_fault(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.code("rois.command.bind", component_ref=TOY)
        await plain.socket.close()
        await app.next("rois.system.profile_changed")
        assert await app.settled() == []
        mood = {"query_type": "component_status", "condition": f"component_ref = '{TOY}'"}
        assert await app.code("rois.query.query", **mood) == "UNSUPPORTED"


class TestEngines:
    @pytest.fixture
    async def failing(self, gateway: Gateway, monkeypatch: pytest.MonkeyPatch) -> None:
        """The gateway has a bug in its queries and its commands."""
        monkeypatch.setattr(gateway.engine, "query", lambda *_asked: 1 / 0)
        monkeypatch.setattr(gateway.engine, "invoke", lambda *_asked: 1 / 0)

    @pytest.mark.usefixtures("failing")
    async def test_every_connected_application_is_notified(self, app: Application, other: Application) -> None:
        await app.code("rois.system.connect")
        error = await other.refused("rois.query.query", query_type="view")
        assert error == {"code": -32603, "message": "Internal error"}
        told = await app.next("rois.system.notify_error")
        assert told["error_type"] == "ENGINE_INTERNAL_ERROR"
        assert await details(app, told["error_id"]) | {"timestamp": ""} == {
            "component_ref": "",
            "error_type": "ENGINE_INTERNAL_ERROR",
            "description": "rois.query.query failed inside the engine",
            "timestamp": "",
        }
        assert await other.settled() == []
        assert await other.ask("rois.system.get_error_detail", error_id=told["error_id"]) == NO_DETAILS
        await app.code("rois.system.disconnect")
        await other.refused("rois.query.query", query_type="view")
        assert await other.next("rois.system.notify_error")
        assert await app.settled() == []

    @pytest.mark.usefixtures("failing")
    async def test_a_command_that_fails_inside_the_engine(self, app: Application) -> None:
        await app.code("rois.system.connect")
        await execute(app, DOOR, "open")
        assert await app.completed("c") == {"c": "ERROR"}
        told = await app.next("rois.system.notify_error")
        assert (await details(app, told["error_id"]))["description"] == "open of robot/door failed inside the engine"

    async def test_what_the_gateway_cannot_take_of_an_adapter(
        self, app: Application, adapter: Adapter, gateway: Gateway, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """A bug in between is the gateway's own fault, and the connection goes on."""
        await app.code("rois.system.connect")
        monkeypatch.setattr("openrois.remote.proxy.EventNotification", None)
        await app.ask("rois.event.subscribe", event_type="switched")
        await app.code("rois.command.bind", component_ref=LAMP)
        await execute(app, LAMP, "switch")
        told = await app.next("rois.system.notify_error")
        assert told["error_id"].startswith("gateway/")
        assert "rois.event.notify_event" in (await details(app, told["error_id"]))["description"]
        assert await app.completed("c") == {"c": "OK"}

    async def test_an_engine_behind_the_gateway(
        self, app: Application, adapter: Adapter, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        await app.code("rois.system.connect")
        monkeypatch.setattr(adapter.host.engine, "query", lambda *_asked: 1 / 0)
        assert await app.code("rois.query.query", query_type="view") == "ERROR"
        told = await app.next("rois.system.notify_error")
        assert told["error_type"] == "ENGINE_INTERNAL_ERROR"
        assert told["error_id"].startswith("robot/")
        assert (await details(app, told["error_id"]))["component_ref"] == ""


class TestPlainAdapters:
    @pytest.fixture
    async def plain(self, gateway: Gateway) -> AsyncIterator[PlainAdapter]:
        async with plain_adapter(gateway) as made:
            await attached(gateway)
            yield made

    async def test_one_without_details(
        self, gateway: Gateway, stack: AsyncExitStack, plain: PlainAdapter, subtests: pytest.Subtests
    ) -> None:
        """Then the fault is that of an engine."""
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.code("rois.system.connect")
        answers: tuple[Any, ...] = (
            ...,
            {"return_code": "BAD_PARAMETER", "results": []},
            {"return_code": "OK", "results": []},
            {"return_code": "OK", "results": None},
        )
        for answer in answers:
            with subtests.test(str(answer)):
                plain.answers["rois.system.get_error_detail"] = answer
                await plain.tell("rois.system.notify_error", error_id="plain/e", error_type="COMPONENT_INTERNAL_ERROR")
                assert await app.next("rois.system.notify_error") == {
                    "error_id": "plain/e",
                    "error_type": "COMPONENT_INTERNAL_ERROR",
                }
                assert plain.last("rois.system.get_error_detail") == {"error_id": "plain/e", "condition": ""}
                found = await details(app, "plain/e")
                assert (found["component_ref"], found["description"]) == ("", "")

    async def test_what_it_may_not_tell(self, gateway: Gateway, stack: AsyncExitStack, plain: PlainAdapter) -> None:
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.code("rois.system.connect")
        kind = "USER_DEFINED_ERROR"
        for params in (
            {"error_id": "gateway/e", "error_type": kind},
            {"error_id": "e", "error_type": kind},
            {"error_id": "plain/e", "error_type": "NO_ERROR"},
            {"error_id": "plain/e"},
        ):
            await plain.tell("rois.system.notify_error", **params)
        plain.profile["component_profiles"]["robot/lamp"] = component_profile("lamp")
        await plain.tell("rois.system.profile_changed")
        await app.next("rois.system.profile_changed")
        foreign = {"name": "component_ref", "data_type_ref": "string", "value": "robot/lamp"}
        plain.answers["rois.system.get_error_detail"] = {"return_code": "OK", "results": [foreign]}
        await plain.tell("rois.system.notify_error", error_id="plain/last", error_type=kind)
        assert (await app.next("rois.system.notify_error"))["error_id"] == "plain/last"
        assert (await details(app, "plain/last"))["component_ref"] == ""
        assert await app.settled() == []

    async def test_a_flood_is_cut(self, gateway: Gateway, stack: AsyncExitStack, plain: PlainAdapter) -> None:
        app = await stack.enter_async_context(deployment.application(gateway))
        await app.code("rois.system.connect")
        for number in range(500):
            await plain.tell("rois.system.notify_error", error_id=f"plain/{number}", error_type="USER_DEFINED_ERROR")
        for _ in range(FAULTS_AT_ONCE):
            await app.next("rois.system.notify_error")
        asked = [method for method, _ in plain.asked if method == "rois.system.get_error_detail"]
        assert FAULTS_AT_ONCE <= len(asked) < FAULTS_AT_ONCE + 20


class TestTwoHops:
    async def test_the_fault_of_a_command_on_what_was_not_bound(self) -> None:
        """It takes the news two questions to come, and the command has ended long before."""
        robot, fleet, gateway = Engine("robot"), Engine("fleet"), Engine("gateway")
        door = Door()
        del door.may_answer
        await robot.attach(LocalRegistry("robot", [door]))
        async with (
            wire.hosted(fleet) as fleet_host,
            wire.adapter_leg(fleet_host, robot),
            wire.hosted(gateway) as gateway_host,
            wire.adapter_leg(gateway_host, fleet),
            wire.application(gateway_host) as app,
        ):
            unit = {"component_ref": DOOR, "command_type": "open", "command_id": "c"}
            await app.ask("rois.command.execute", command_unit_list=[unit])
            assert await app.next("rois.command.completed") == {"command_id": "c", "status": "ERROR"}
            told = await app.next("rois.system.notify_error")
            assert told["error_type"] == "COMPONENT_INTERNAL_ERROR"
            assert told["error_id"].startswith("robot/")
            answer = await app.ask("rois.system.get_error_detail", error_id=told["error_id"])
            assert answer["results"][0] == {"name": "component_ref", "data_type_ref": "RoISIdentifier", "value": DOOR}
