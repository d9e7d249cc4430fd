"""The Command interface: reservation, parameters, sequences, results."""

import asyncio
from contextlib import AsyncExitStack
from typing import Any

import pytest

from openrois.commands.history import MAX_RUNNING
from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot

LAMP, BELL, DOOR = "robot/lamp", "robot/bell", "robot/door"
LAMPS = "component_type LIKE '%::Lamp'"


def unit(command_id: str, command: str = "switch", ref: str = LAMP, **more: Any) -> dict[str, Any]:
    return {"component_ref": ref, "command_type": command, "command_id": command_id, **more}


def value(name: str, text: str) -> dict[str, str]:
    return {"name": name, "data_type_ref": "whatever", "value": text}


async def execute(app: Application, *units: dict[str, Any]) -> str:
    return await app.code("rois.command.execute", command_unit_list=list(units))


async def bind(app: Application, ref: str = LAMP) -> str:
    return await app.code("rois.command.bind", component_ref=ref)


async def results(app: Application, command_id: str) -> list[dict[str, str]]:
    answer = await app.ask("rois.command.get_command_result", command_id=command_id)
    assert answer["return_code"] == "OK"
    found: list[dict[str, str]] = answer["results"]
    return found


class TestSearch:
    async def test_components_in_the_order_of_the_profile(self, app: Application, subtests: pytest.Subtests) -> None:
        everything = [LAMP, BELL, DOOR, "robot/camera"]
        for condition, refs in [
            ("", everything),
            ("component_ref = 'robot/bell'", [BELL]),
            ("component_ref LIKE 'robot/_e%'", [BELL]),
            ("component_type = 'urn:x-rois:def:component:Test::Lamp' AND component_ref LIKE '%'", [LAMP]),
            ("component_type = 'Lamp'", []),
        ]:
            with subtests.test(condition):
                assert await app.ask("rois.command.search", condition=condition) == {
                    "return_code": "OK",
                    "component_ref_list": refs,
                }

    async def test_a_condition_that_cannot_be_read(self, app: Application) -> None:
        for condition in ("x", "name = 'lamp'", "component_ref = 'a' OR component_ref = 'b'", "x" * 5000):
            assert await app.ask("rois.command.search", condition=condition) == {
                "return_code": "BAD_PARAMETER",
                "component_ref_list": [],
            }


class TestBind:
    async def test_an_actuation_has_one_holder(self, app: Application, other: Application) -> None:
        assert await bind(app) == "OK"
        assert await bind(app) == "OK"
        assert await bind(other) == "OUT_OF_RESOURCES"
        assert await other.code("rois.command.release", component_ref=LAMP) == "OK"
        assert await bind(other) == "OUT_OF_RESOURCES"
        assert await app.code("rois.command.release", component_ref=LAMP) == "OK"
        assert await bind(other) == "OK"

    async def test_other_classes_are_not_reserved(self, app: Application, other: Application) -> None:
        for ref in (BELL, DOOR, "robot/camera"):
            assert [await bind(app, ref), await bind(other, ref)] == ["OK", "OK"]

    async def test_an_unknown_component(self, app: Application) -> None:
        for ref in ("robot/nobody", "nowhere/lamp", "lamp", "", "robot/lamp/x", "gateway/lamp"):
            assert await bind(app, ref) == "UNSUPPORTED"
            assert await app.code("rois.command.release", component_ref=ref) == "UNSUPPORTED"

    async def test_bind_any_takes_a_free_one(self, app: Application, other: Application) -> None:
        free = {"return_code": "OK", "component_ref": LAMP}
        assert await app.ask("rois.command.bind_any", condition=LAMPS) == free
        assert await app.ask("rois.command.bind_any", condition=LAMPS) == free
        for condition, code in (
            (LAMPS, "OUT_OF_RESOURCES"),
            ("component_ref = 'x'", "UNSUPPORTED"),
            ("x", "BAD_PARAMETER"),
        ):
            answer = await other.ask("rois.command.bind_any", condition=condition)
            assert answer == {"return_code": code, "component_ref": ""}
        assert (await other.ask("rois.command.bind_any"))["component_ref"] == BELL

    async def test_a_session_that_ends_releases(self, other: Application, gateway: Gateway) -> None:
        async with deployment.application(gateway) as leaving:
            assert await bind(leaving) == "OK"
            assert await bind(other) == "OUT_OF_RESOURCES"
        await other.eventually("OK", "rois.command.bind", component_ref=LAMP)


class TestParameters:
    async def test_get_parameter(self, app: Application) -> None:
        answer = await app.ask("rois.command.get_parameter", component_ref=LAMP)
        assert answer["parameters"] == [
            {"name": "colour", "data_type_ref": "string", "value": "white"},
            {"name": "level", "data_type_ref": "int", "value": "5"},
        ]
        assert (await app.ask("rois.command.get_parameter", component_ref=BELL))["parameters"] == []
        answer = await app.ask("rois.command.get_parameter", component_ref="robot/x")
        assert answer == {"return_code": "UNSUPPORTED", "parameters": []}

    async def test_set_parameter_is_a_command_with_an_id_of_the_engine(self, app: Application, robot: Robot) -> None:
        assert await bind(app) == "OK"
        answer = await app.ask(
            "rois.command.set_parameter",
            component_ref=LAMP,
            parameters=[value("colour", ""), value("level", "-0")],
        )
        assert answer["command_id"].startswith("robot/")
        assert app.told == []
        assert await app.completed(answer["command_id"]) == {answer["command_id"]: "OK"}
        assert await results(app, answer["command_id"]) == []
        stored = await app.ask("rois.command.get_parameter", component_ref=LAMP)
        assert stored["parameters"] == [{"name": "level", "data_type_ref": "int", "value": "-0"}]

    async def test_what_set_parameter_refuses(self, app: Application, robot: Robot, subtests: pytest.Subtests) -> None:
        assert await app.code("rois.command.set_parameter", component_ref=LAMP, parameters=[]) == "OUT_OF_RESOURCES"
        assert await bind(app) == "OK"
        for ref, parameters, code in [
            (LAMP, [], "OK"),
            ("robot/x", [], "UNSUPPORTED"),
            (BELL, [], "UNSUPPORTED"),
            (LAMP, [value("shape", "round")], "BAD_PARAMETER"),
            (LAMP, [value("level", "+5")], "BAD_PARAMETER"),
            (LAMP, [value("colour", "red"), value("level", "much")], "BAD_PARAMETER"),
            (LAMP, [value("level", "1"), value("level", "2")], "BAD_PARAMETER"),
        ]:
            with subtests.test(f"{ref} {parameters}"):
                answer = await app.ask("rois.command.set_parameter", component_ref=ref, parameters=parameters)
                assert answer["return_code"] == code
                assert bool(answer["command_id"]) == (code == "OK")
        assert robot.lamp.parameters == {"colour": "white", "level": 5}

    async def test_set_parameter_as_a_command_unit(self, app: Application, robot: Robot) -> None:
        await bind(app)
        assert await execute(app, unit("p", "set_parameter", arguments=[value("colour", "red")])) == "OK"
        assert await app.completed("p") == {"p": "OK"}
        assert robot.lamp.parameters["colour"] == "red"
        assert await execute(app, unit("q", "set_parameter", BELL)) == "UNSUPPORTED"


class TestExecute:
    async def test_reply_then_completed_then_result(self, app: Application) -> None:
        await bind(app)
        assert await execute(app, unit("c1", arguments=[value("times", "3")])) == "OK"
        assert app.told == []
        assert await app.completed("c1") == {"c1": "OK"}
        assert await results(app, "c1") == [{"name": "total", "data_type_ref": "int", "value": "3"}]
        assert await app.settled() == []

    async def test_refusals_and_their_order(self, app: Application, robot: Robot, subtests: pytest.Subtests) -> None:
        bad = [value("times", "many")]
        for units, code in [
            ([unit("a", ref="robot/x", arguments=bad)], "UNSUPPORTED"),
            ([unit("a", "explode")], "UNSUPPORTED"),
            ([unit("a", arguments=bad)], "OUT_OF_RESOURCES"),
            ([unit("")], "OUT_OF_RESOURCES"),
        ]:
            with subtests.test(f"unbound {units}"):
                assert await execute(app, *units) == code
        await bind(app)
        for units, code in [
            ([unit("a", arguments=bad)], "BAD_PARAMETER"),
            ([unit("a", arguments=[value("colour", "red")])], "BAD_PARAMETER"),
            ([unit("a", arguments=[value("note", "x"), value("note", "x")])], "BAD_PARAMETER"),
            ([unit("", arguments=bad)], "BAD_PARAMETER"),
            ([unit("")], "BAD_PARAMETER"),
            ([unit("a"), unit("a")], "BAD_PARAMETER"),
            ([unit("a"), {"command_list": [unit("b"), unit("a")]}], "BAD_PARAMETER"),
            ([unit("gateway/1")], "BAD_PARAMETER"),
            ([unit("robot/1")], "BAD_PARAMETER"),
            ([{"command_list": []}], "BAD_PARAMETER"),
            ([unit("a"), unit("b", "explode")], "UNSUPPORTED"),
            ([unit("a", arguments=bad), unit("b", "explode")], "BAD_PARAMETER"),
            ([unit("a"), unit("b", "list", DOOR, arguments=[value("numbers", "[" * 20_000)])], "BAD_PARAMETER"),
        ]:
            with subtests.test(f"bound {units}"[:100]):
                assert await execute(app, *units) == code
        assert robot.lamp.total == 0
        assert await app.settled() == []
        assert await execute(app, unit("a"), unit("x/1"), unit("robot")) == "OK"
        assert await app.completed("a", "x/1", "robot") == {"a": "OK", "x/1": "OK", "robot": "OK"}

    async def test_a_held_component_is_refused_to_others(self, app: Application, other: Application) -> None:
        await bind(app)
        assert await execute(other, unit("c")) == "OUT_OF_RESOURCES"
        assert await execute(other, unit("o", "open", DOOR), unit("c")) == "OUT_OF_RESOURCES"

    async def test_other_classes_need_no_bind(self, app: Application, robot: Robot) -> None:
        assert await execute(app, unit("o", "open", DOOR, arguments=[value("how", "wide")])) == "OK"
        assert await app.completed("o") == {"o": "OK"}
        assert robot.door.opened == ["wide"]

    async def test_an_id_is_taken_while_it_is_remembered(self, app: Application, robot: Robot) -> None:
        robot.door.may_answer.clear()
        assert await execute(app, unit("o", "open", DOOR)) == "OK"
        assert await execute(app, unit("o", "open", DOOR)) == "BAD_PARAMETER"
        robot.door.may_answer.set()
        await app.completed("o")
        assert await execute(app, unit("o", "open", DOOR)) == "BAD_PARAMETER"
        assert len(robot.door.opened) == 1

    async def test_how_commands_end(self, app: Application, robot: Robot) -> None:
        await bind(app)
        ends = {"fail": "ERROR", "time_out": "TIMEOUT", "crash": "ERROR"}
        for command, status in ends.items():
            assert await execute(app, unit(command, command)) == "OK"
            assert await app.completed(command) == {command: status}
            assert await results(app, command) == []
        assert await execute(app, unit("s", "start")) == "OK"
        async with deployment.patience():
            await robot.lamp.glowing.wait()
        assert await results(app, "s") == []
        assert await execute(app, unit("t", "stop")) == "OK"
        assert await app.completed("s", "t") == {"s": "ABORT", "t": "OK"}


class TestSequences:
    async def test_items_run_one_after_another_and_delays_pass(self, app: Application, robot: Robot) -> None:
        how = [unit(str(n), "open", DOOR, arguments=[value("how", str(n))], delay_time=1) for n in range(5)]
        concurrent = {"command_list": [how[2], how[3]], "delay_time": 1}
        assert await execute(app, how[0], how[1], concurrent, how[4]) == "OK"
        assert await app.completed(*"01234") == dict.fromkeys("01234", "OK")
        opened = robot.door.opened
        assert (opened[:2], sorted(opened[2:4]), opened[4:]) == (["0", "1"], ["2", "3"], ["4"])

    async def test_concurrent_commands_run_side_by_side(self, app: Application, robot: Robot) -> None:
        await bind(app)
        robot.door.may_answer.clear()
        side_by_side = {"command_list": [unit("o", "open", DOOR), unit("l")]}
        assert await execute(app, side_by_side, unit("after", "open", DOOR)) == "OK"
        assert await app.completed("l") == {"l": "OK"}
        assert await results(app, "o") == []
        robot.door.may_answer.set()
        assert await app.completed("o", "after") == {"o": "OK", "after": "OK"}

    async def test_what_follows_a_failure_is_aborted_without_having_run(self, app: Application, robot: Robot) -> None:
        await bind(app)
        assert (
            await execute(
                app,
                unit("first"),
                {"command_list": [unit("fails", "fail"), unit("beside")]},
                unit("after"),
                {"command_list": [unit("later"), unit("latest")]},
            )
            == "OK"
        )
        ended = await app.completed("first", "fails", "beside", "after", "later", "latest")
        assert ended == {
            "first": "OK",
            "fails": "ERROR",
            "beside": "OK",
            "after": "ABORT",
            "later": "ABORT",
            "latest": "ABORT",
        }
        assert robot.lamp.total == 2
        assert await results(app, "later") == []
        assert await app.settled() == []


async def test_a_bug_in_between_still_completes(
    app: Application, gateway: Gateway, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gateway.engine, "invoke", lambda *_asked: 1 / 0)
    assert await execute(app, unit("o", "open", DOOR), unit("p", "open", DOOR)) == "OK"
    assert await app.completed("o", "p") == {"o": "ERROR", "p": "ABORT"}


class TestResults:
    async def test_what_is_refused(self, app: Application, other: Application) -> None:
        assert await execute(other, unit("theirs", "open", DOOR)) == "OK"
        await other.completed("theirs")
        refused = {"return_code": "BAD_PARAMETER", "results": []}
        for params in ({"command_id": "nobody's"}, {"command_id": "theirs"}, {"command_id": ""}):
            assert await app.ask("rois.command.get_command_result", **params) == refused
        params = {"command_id": "theirs", "condition": "component_ref = 'x'"}
        assert await other.ask("rois.command.get_command_result", **params) == refused

    async def test_two_sessions_may_use_the_same_id(self, app: Application, other: Application) -> None:
        for session, how in ((app, "wide"), (other, "a little")):
            assert await execute(session, unit("c", "open", DOOR, arguments=[value("how", how)])) == "OK"
        for session, how in ((app, "wide"), (other, "a little")):
            assert await session.completed("c") == {"c": "OK"}
            assert (await results(session, "c"))[0]["value"] == how
            assert await session.settled() == []


class TestAdapterLost:
    async def test_running_commands_end_with_error_once(self, app: Application, adapter: Adapter, robot: Robot) -> None:
        await bind(app)
        assert await execute(app, {"command_list": [unit("s", "start")]}, unit("next")) == "OK"
        async with deployment.patience():
            await robot.lamp.glowing.wait()
        await adapter.stop()
        assert await app.completed("s", "next") == {"s": "ERROR", "next": "ABORT"}
        assert await app.next("rois.system.profile_changed") == {}
        assert await execute(app, unit("x")) == "UNSUPPORTED"
        assert await app.settled() == []

    async def test_it_comes_back_unbound(self, app: Application, other: Application, adapter: Adapter) -> None:
        await bind(app)
        await adapter.stop()
        await adapter.start()
        assert await execute(app, unit("c")) == "OUT_OF_RESOURCES"
        assert await bind(other) == "OK"

    async def test_a_call_that_waits_ends_with_error(self, app: Application, adapter: Adapter, robot: Robot) -> None:
        robot.door.may_answer.clear()
        waiting = await app.begin("rois.query.query", query_type="view")
        async with deployment.patience():
            await robot.door.asked.wait()
        await adapter.stop()
        assert (await app.answer(waiting))["result"] == {"return_code": "ERROR", "results": []}


async def test_commands_of_a_session_that_left_go_on(adapter: Adapter, gateway: Gateway, robot: Robot) -> None:
    robot.door.may_answer.clear()
    async with deployment.application(gateway) as leaving:
        assert await execute(leaving, unit("o", "open", DOOR), unit("p", "open", DOOR)) == "OK"
        async with deployment.patience():
            await robot.door.asked.wait()
    robot.door.may_answer.set()
    async with deployment.application(gateway) as app:
        assert await execute(app, unit("q", "open", DOOR)) == "OK"
        await app.completed("q")
        while len(robot.door.opened) < 3:
            await app.settled()


async def test_what_is_left_of_a_sequence_stays_off_what_another_has_bound(
    app: Application, other: Application, robot: Robot
) -> None:
    robot.door.may_answer.clear()
    await bind(app)
    assert await execute(app, unit("open", "open", DOOR), unit("late"), unit("last")) == "OK"
    await app.ask("rois.command.release", component_ref=LAMP)
    assert await bind(other) == "OK"
    robot.door.may_answer.set()
    assert await app.completed("open", "late", "last") == {"open": "OK", "late": "OUT_OF_RESOURCES", "last": "ABORT"}
    assert robot.lamp.total == 0


async def test_what_is_left_of_a_sequence_runs_on_what_nobody_has_bound(app: Application, robot: Robot) -> None:
    robot.door.may_answer.clear()
    await bind(app)
    assert await execute(app, unit("open", "open", DOOR), unit("late")) == "OK"
    await app.ask("rois.command.release", component_ref=LAMP)
    robot.door.may_answer.set()
    assert await app.completed("open", "late") == {"open": "OK", "late": "OK"}


class TestVeryMany:
    """As many commands as one application may have at a time."""

    IDS = tuple(str(number) for number in range(MAX_RUNNING))

    async def begin(self, app: Application) -> None:
        for first in range(0, MAX_RUNNING, MAX_RUNNING // 2):
            units = [unit(command_id, "open", DOOR) for command_id in self.IDS[first : first + MAX_RUNNING // 2]]
            assert await execute(app, {"command_list": units}) == "OK"

    async def test_their_adapter_stays_however_many_start_at_once(self, robot: Robot, stack: AsyncExitStack) -> None:
        # How long a busy machine takes for so many is not what it is about.
        gateway = await stack.enter_async_context(deployment.gateway(adapter_timeout=60))
        await stack.enter_async_context(deployment.adapter(gateway, *robot.parts()))
        other = await stack.enter_async_context(deployment.application(gateway))
        robot.door.may_answer.clear()
        apps = [await stack.enter_async_context(deployment.application(gateway)) for _ in range(4)]
        await asyncio.gather(*(self.begin(app) for app in apps))
        robot.door.may_answer.set()
        for app in apps:
            assert set((await app.completed(*self.IDS)).values()) == {"OK"}
        assert await other.settled() == []

    async def test_others_are_served(self, app: Application, other: Application, robot: Robot) -> None:
        robot.door.may_answer.clear()
        await self.begin(app)
        assert await bind(other) == "OK"
        assert await execute(other, unit("mine")) == "OK"
        assert await other.completed("mine") == {"mine": "OK"}

    async def test_their_application_stays_when_they_end_at_once(
        self, app: Application, adapter: Adapter, robot: Robot
    ) -> None:
        robot.door.may_answer.clear()
        await self.begin(app)
        async with deployment.patience():
            await robot.door.asked.wait()
        await adapter.stop()
        assert set((await app.completed(*self.IDS)).values()) == {"ERROR"}
        assert await app.code("rois.system.connect") == "OK"
