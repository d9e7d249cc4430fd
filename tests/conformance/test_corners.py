"""The corners of the wire, where implementations differ: numbers, nulls, depths, lengths and orders."""

import json
import logging
from contextlib import AsyncExitStack
from typing import Any

import pytest

from openrois.gateway.server import Gateway
from openrois.types.codes import ComponentStatus
from openrois.types.methods import METHODS, NOTIFICATIONS
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot
from tests.support.plain import TOY, attached, plain_adapter

DOOR, LAMP = "robot/door", "robot/lamp"
DIGITS = "9" * 4000


def unit(command_id: str = "c", **more: Any) -> dict[str, Any]:
    return {"component_ref": DOOR, "command_type": "open", "command_id": command_id, **more}


def number(text: str) -> dict[str, str]:
    return {"name": "numbers", "data_type_ref": "int[]", "value": text}


async def raw(app: Application, params: str, method: str = "rois.command.execute") -> dict[str, Any]:
    """Send params as they are and return the response."""
    await app.send(f'{{"jsonrpc":"2.0","id":"raw","method":"{method}","params":{params}}}')
    return await app.hear()


async def test_every_method_of_the_table_is_served_and_no_other(app: Application, subtests: pytest.Subtests) -> None:
    base = [method.name for method in METHODS if not method.extension]
    assert (len(base), len([told for told in NOTIFICATIONS if not told.extension])) == (16, 4)
    for method in METHODS:
        with subtests.test(method.name):
            assert (await app.refused(method.name, nonsense=1))["code"] == -32602
    for told in NOTIFICATIONS:
        assert (await app.refused(told.name))["code"] == -32601


class TestNumbers:
    async def test_a_delay_is_a_whole_number_from_zero_to_a_day(
        self, app: Application, subtests: pytest.Subtests
    ) -> None:
        texts = ('"20"', "20.0", "2e1", "true", "-5", "-1", "[]", "86400001", DIGITS, "1e999")
        for text in texts:
            for wrapped in ('{{"command_unit_list":[{0}]}}', '{{"command_unit_list":[{{"command_list":[{0}]}}]}}'):
                with subtests.test(f"{text[:20]} {wrapped}"):
                    params = wrapped.format(json.dumps(unit())[:-1] + f',"delay_time":{text}}}')
                    error = (await raw(app, params))["error"]
                    assert error["code"] == -32602
                    (problem,) = error["data"]
                    assert problem["path"].endswith("0.delay_time")
        assert await app.settled() == []

    async def test_none_and_zero_are_no_delay(self, app: Application) -> None:
        units = [unit("a", delay_time=None), unit("b", delay_time=0), {"command_list": [unit("c")], "delay_time": None}]
        assert await app.code("rois.command.execute", command_unit_list=units) == "OK"
        assert await app.completed("a", "b", "c") == {"a": "OK", "b": "OK", "c": "OK"}

    async def test_numbers_of_thousands_of_digits_are_answered(self, app: Application, robot: Robot) -> None:
        """In a value they do not fit; as an id they are one; in JSON there is an end."""
        for text in (DIGITS, "-" + DIGITS, f"[{DIGITS}]", f"[[{DIGITS}]]", "[" + "9" * 5000 + "]", "[1.0]", "[true]"):
            units = [unit(command_type="list", arguments=[number(text)])]
            assert await app.code("rois.command.execute", command_unit_list=units) == "BAD_PARAMETER"
        response = await raw(app, "{}", "rois.system.connect")
        assert response["result"] == {"return_code": "OK"}
        await app.send(f'{{"jsonrpc":"2.0","id":{DIGITS},"method":"rois.system.connect"}}')
        assert (await app.hear())["id"] == int(DIGITS)
        await app.send(f'{{"jsonrpc":"2.0","id":{"9" * 5000},"method":"rois.system.connect"}}')
        response = await app.hear()
        assert (response["id"], response["error"]["code"]) == (None, -32700)
        assert robot.door.opened == []


class TestShapes:
    async def test_lists_may_be_absent_and_not_null(self, app: Application) -> None:
        assert await app.code("rois.command.execute", command_unit_list=[unit("absent")]) == "OK"
        await app.completed("absent")
        misfits: list[tuple[str, dict[str, Any], str]] = [
            ("rois.command.execute", {"command_unit_list": [unit(arguments=None)]}, "command_unit_list.0.arguments"),
            ("rois.command.execute", {"command_unit_list": None}, "command_unit_list"),
            ("rois.command.execute", {"command_unit_list": [None]}, "command_unit_list.0"),
            ("rois.command.execute", {"command_unit_list": {"0": unit()}}, "command_unit_list"),
            ("rois.command.execute", {"command_unit_list": [{"command_list": None}]},
             "command_unit_list.0.command_list"),
            ("rois.command.set_parameter", {"component_ref": LAMP, "parameters": None}, "parameters"),
            ("rois.command.set_parameter", {"component_ref": LAMP}, "parameters"),
            ("rois.event.unsubscribe", {"subscribe_id": None}, "subscribe_id"),
        ]  # fmt: skip
        for method, params, path in misfits:
            error = await app.refused(method, **params)
            assert (error["code"], [problem["path"] for problem in error["data"]]) == (-32602, [path])

    async def test_a_path_leads_to_the_misfit_inside(self, app: Application) -> None:
        wrong = {**unit("d"), "arguments": [number("1"), {**number("2"), "unit": "mm"}]}
        sequence = [unit("a"), {"command_list": [unit("b"), wrong]}]
        error = await app.refused("rois.command.execute", command_unit_list=sequence)
        (problem,) = error["data"]
        assert problem["path"] == "command_unit_list.1.command_list.1.arguments.1.unit"

    async def test_one_item_is_a_command_or_a_list_and_nothing_else(self, app: Application) -> None:
        for item in (
            {},
            {"command_list": [unit()], "command_id": "c"},
            {"command_list": [{"command_list": [unit()]}]},
            {**unit(), "branch_list": []},
            "start",
        ):
            assert (await app.refused("rois.command.execute", command_unit_list=[item]))["code"] == -32602

    async def test_an_empty_list_of_concurrent_commands(self, app: Application) -> None:
        """Alone there is nothing to do; beside commands it is a pause."""
        pause: dict[str, Any] = {"command_list": [], "delay_time": 1}
        assert await app.code("rois.command.execute", command_unit_list=[pause]) == "BAD_PARAMETER"
        assert await app.code("rois.command.execute", command_unit_list=[pause, pause]) == "BAD_PARAMETER"
        assert await app.code("rois.command.execute", command_unit_list=[unit("a"), pause, unit("b")]) == "OK"
        assert await app.completed("a", "b") == {"a": "OK", "b": "OK"}

    async def test_deep_values_do_not_fit(self, app: Application) -> None:
        for depth in (2, 9, 500, 20_000):
            units = [unit(command_type="list", arguments=[number("[" * depth + "]" * depth)])]
            assert await app.code("rois.command.execute", command_unit_list=units) == "BAD_PARAMETER"

    async def test_deep_params_are_answered(self, app: Application) -> None:
        deep = "[" * 500 + "]" * 500
        error = (await raw(app, f'{{"command_unit_list":{deep}}}'))["error"]
        assert error["code"] == -32602
        error = (await raw(app, f'{{"condition":{deep}}}', "rois.command.search"))["error"]
        assert error["code"] == -32602


class TestRefusals:
    async def test_a_failure_has_every_field_with_its_default(
        self, app: Application, subtests: pytest.Subtests
    ) -> None:
        calls: list[tuple[str, dict[str, Any], str, dict[str, Any]]] = [
            ("rois.system.get_profile", {"condition": "x"}, "BAD_PARAMETER",
             {"profile": None, "component_profiles": {}}),
            ("rois.system.get_error_detail", {"error_id": "x"}, "BAD_PARAMETER", {"results": []}),
            ("rois.command.search", {"condition": "x"}, "BAD_PARAMETER", {"component_ref_list": []}),
            ("rois.command.bind", {"component_ref": "x"}, "UNSUPPORTED", {}),
            ("rois.command.bind_any", {"condition": "x"}, "BAD_PARAMETER", {"component_ref": ""}),
            ("rois.command.release", {"component_ref": "x"}, "UNSUPPORTED", {}),
            ("rois.command.get_parameter", {"component_ref": "x"}, "UNSUPPORTED", {"parameters": []}),
            ("rois.command.set_parameter", {"component_ref": "x", "parameters": []}, "UNSUPPORTED",
             {"command_id": ""}),
            ("rois.command.execute", {"command_unit_list": [unit("")]}, "BAD_PARAMETER", {}),
            ("rois.command.get_command_result", {"command_id": "x"}, "BAD_PARAMETER", {"results": []}),
            ("rois.query.query", {"query_type": "x"}, "UNSUPPORTED", {"results": []}),
            ("rois.event.subscribe", {"event_type": "x"}, "UNSUPPORTED", {"subscribe_id": ""}),
            ("rois.event.get_event_detail", {"event_id": "x"}, "BAD_PARAMETER", {"results": []}),
        ]  # fmt: skip
        for method, params, code, defaults in calls:
            with subtests.test(method):
                assert await app.ask(method, **params) == {"return_code": code, **defaults}

    async def test_a_component_that_cannot_work_takes_no_subscription(
        self, app: Application, robot: Robot, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        for status in (ComponentStatus.UNINITIALIZED, ComponentStatus.ERROR):
            monkeypatch.setattr(robot.bell, "condition", lambda status=status: status)
            answer = await app.ask("rois.event.subscribe", event_type="rang")
            assert answer == {"return_code": "ERROR", "subscribe_id": ""}
        monkeypatch.undo()
        assert await app.code("rois.event.subscribe", event_type="rang") == "OK"

    async def test_an_id_that_begins_with_an_engines(
        self, app: Application, adapter: Adapter, stack: AsyncExitStack, gateway: Gateway
    ) -> None:
        """Whose id it is: the gateway's own, an adapter's, one further down; not one of an engine that is not there."""
        await stack.enter_async_context(deployment.two_level(adapter, engine_id="below"))
        await deployment.until(gateway.engine, lambda ids: "below" in ids)
        for command_id in ("gateway/x", "robot/x", "below/x", "robot/"):
            assert await app.code("rois.command.execute", command_unit_list=[unit(command_id)]) == "BAD_PARAMETER"
        for command_id in ("above/x", "/x", "gateway", "robotic/x", "x/robot/"):
            assert await app.code("rois.command.execute", command_unit_list=[unit(command_id)]) == "OK"
            await app.completed(command_id)


class TestPlainAdapters:
    async def test_what_does_not_fit_its_profile_is_passed_on_and_counted(
        self, gateway: Gateway, stack: AsyncExitStack, caplog: pytest.LogCaptureFixture
    ) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        odd = {"name": "shape", "data_type_ref": "string", "value": "round"}
        plain.answers["rois.query.query"] = {"return_code": "OK", "results": [odd]}
        plain.answers["rois.command.get_parameter"] = {"return_code": "OK", "parameters": [odd]}
        plain.answers["rois.command.get_command_result"] = {"return_code": "OK", "results": [odd]}
        with caplog.at_level(logging.INFO, "openrois"):
            assert (await app.ask("rois.query.query", query_type="mood"))["results"] == [odd]
            assert (await app.ask("rois.command.get_parameter", component_ref=TOY))["parameters"] == [odd]
            say = {"component_ref": TOY, "command_type": "say", "command_id": "c"}
            assert await app.code("rois.command.execute", command_unit_list=[say]) == "OK"
            await app.completed("c")
            assert (await app.ask("rois.command.get_command_result", command_id="c"))["results"] == [odd]
            await app.ask("rois.event.subscribe", event_type="laughed")
            await plain.tell_event(f"plain/sub-{plain.minted}", "laughed")
            await app.next("rois.event.notify_event")
        counted = [record.getMessage() for record in caplog.records if "do not fit" in record.getMessage()]
        assert [message.partition(", now ")[0][-8:] for message in counted] == ["1 so far", "2 so far", "4 so far"]
        assert all("shape" in message for message in counted[:2])

    async def test_an_event_that_has_expired_has_no_details(self, gateway: Gateway, stack: AsyncExitStack) -> None:
        plain = await stack.enter_async_context(plain_adapter(gateway))
        await attached(gateway)
        app = await stack.enter_async_context(deployment.application(gateway))
        plain.answers["rois.event.subscribe"] = {"return_code": "OK", "subscribe_id": "plain/s"}
        await app.ask("rois.event.subscribe", event_type="laughed")
        for expire, code in (
            ("2020-01-01T00:00:00+00:00", "BAD_PARAMETER"),
            ("2990-01-01T00:00:00Z", "OK"),
            ("", "OK"),
            ("soon", "OK"),
        ):
            event_id = f"plain/{expire}"
            event = {"event_id": event_id, "event_type": "laughed", "subscribe_id": "plain/s", "expire": expire}
            await plain.tell("rois.event.notify_event", **event)
            assert (await app.next("rois.event.notify_event"))["expire"] == expire
            assert await app.code("rois.event.get_event_detail", event_id=event_id) == code
