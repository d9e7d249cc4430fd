"""The engine behind the suite's own adapter answers as an adapter of the base wire does."""

from typing import Any

import pytest
from openrois_conformance.probe_engine import SILENCE, Answer, ProbeEngine
from openrois_conformance.probe_profiles import FATES, component_profiles, profile_result

pytestmark = pytest.mark.extra(name="base")

ARM = "probe/arm"
BELOW = "probe-below/deep"


@pytest.fixture
def engine() -> ProbeEngine:
    return ProbeEngine("probe", component_profiles("probe"))


def result(answer: Answer) -> dict[str, Any]:
    assert answer.result is not None
    return dict(answer.result)


def execute(engine: ProbeEngine, command_type: str, command_id: str = "c", **more: Any) -> Answer:
    unit = {"component_ref": ARM, "command_type": command_type, "command_id": command_id, **more}
    return engine.answer_request("rois.command.execute", {"command_unit_list": [unit]})


def outcome(engine: ProbeEngine, command_id: str = "c") -> Any:
    return result(engine.answer_request("rois.command.get_command_result", {"command_id": command_id}))["results"]


def completed(status: str) -> tuple[str, dict[str, Any]]:
    return "rois.command.completed", {"command_id": "c", "status": status}


def test_its_profile_is_of_two_engines(engine: ProbeEngine) -> None:
    profile = result(engine.answer_request("rois.system.get_profile", {"condition": ""}))["profile"]
    assert profile["identifier"]["code"] == "probe"
    assert [below["component_ids"] for below in profile["sub_profiles"]] == [[BELOW]]
    alone = {ref: kept for ref, kept in engine.profiles.items() if ref != BELOW}
    assert profile_result("probe", alone)["profile"]["sub_profiles"] == []


class TestCommands:
    def test_one_that_gives_back_what_it_got(self, engine: ProbeEngine) -> None:
        value = {"name": "count", "data_type_ref": "int", "value": "3"}
        assert execute(engine, "echo", arguments=[value]).then == (completed("OK"),)
        assert outcome(engine) == [value]
        execute(engine, "echo", "without")
        assert outcome(engine, "without") == []

    @pytest.mark.parametrize(("command", "status"), FATES.items())
    def test_those_that_end_badly(self, engine: ProbeEngine, command: str, status: str) -> None:
        assert execute(engine, command).then == (completed(status),)
        assert outcome(engine) == []

    def test_those_that_do_not_begin(self, engine: ProbeEngine) -> None:
        assert result(execute(engine, "refuse")) == {"return_code": "OUT_OF_RESOURCES"}
        assert execute(engine, "crash").error == -32603
        assert execute(engine, "ignore") is SILENCE

    def test_one_that_hangs(self, engine: ProbeEngine) -> None:
        assert execute(engine, "hang").then == ()
        assert engine.hanging() == {ARM: ["c"]}
        assert engine.finish(ARM, "ABORT") == (completed("ABORT"),)
        assert engine.finish(ARM, "ABORT") == ()

    def test_an_unknown_one(self, engine: ProbeEngine) -> None:
        execute(engine, "unheard_of")
        assert outcome(engine) == []


def test_parameters(engine: ProbeEngine) -> None:
    value = {"name": "label", "data_type_ref": "string", "value": "new"}
    answer = engine.answer_request("rois.command.set_parameter", {"component_ref": ARM, "parameters": [value]})
    command_id = result(answer)["command_id"]
    assert command_id.startswith("probe/")
    assert answer.then == (("rois.command.completed", {"command_id": command_id, "status": "OK"}),)
    stored = result(engine.answer_request("rois.command.get_parameter", {"component_ref": ARM}))["parameters"]
    assert value in stored
    assert "since" not in [parameter["name"] for parameter in stored], "it has no value"
    engine.reset()
    stored = result(engine.answer_request("rois.command.get_parameter", {"component_ref": ARM}))["parameters"]
    assert value not in stored


def test_queries(engine: ProbeEngine) -> None:
    def ask(name: str) -> Answer:
        return engine.answer_request("rois.query.query", {"query_type": name, "condition": f"component_ref = '{ARM}'"})

    assert [value["name"] for value in result(ask("view"))["results"]] == ["label"]
    assert ask("hang_of_arm") is SILENCE
    assert ask("crash_of_arm").error == -32603


class TestEvents:
    def subscribe(self, engine: ProbeEngine, condition: str) -> str:
        params = {"event_type": "happened", "condition": condition}
        return str(result(engine.answer_request("rois.event.subscribe", params))["subscribe_id"])

    def test_subscribers_are_told(self, engine: ProbeEngine) -> None:
        subscribe_id = self.subscribe(engine, f"component_ref = '{ARM}'")
        event_id, notices = engine.event(ARM, "happened")
        ((name, told),) = notices
        assert name == "rois.event.notify_event"
        assert (told["event_id"], told["subscribe_id"]) == (event_id, subscribe_id)
        details = result(engine.answer_request("rois.event.get_event_detail", {"event_id": event_id}))
        assert details["results"] == told["results"]
        assert engine.event(BELOW, "happened")[1] == ()
        engine.answer_request("rois.event.unsubscribe", {"subscribe_id": subscribe_id})
        assert engine.event(ARM, "happened")[1] == ()

    def test_a_condition_of_nothing_is_noted(self, engine: ProbeEngine) -> None:
        self.subscribe(engine, "component_ref = 'probe/absent'")
        assert len(engine.violations) == 1


def test_faults(engine: ProbeEngine) -> None:
    _, told = engine.fault(ARM, "USER_DEFINED_ERROR")
    details = engine.answer_request("rois.system.get_error_detail", {"error_id": told["error_id"]})
    assert {value["name"]: value["value"] for value in result(details)["results"]}["component_ref"] == ARM
    _, told = engine.fault("", "ENGINE_INTERNAL_ERROR")
    details = engine.answer_request("rois.system.get_error_detail", {"error_id": told["error_id"]})
    assert result(details) == {"return_code": "BAD_PARAMETER", "results": []}


def test_answers_can_be_added_and_replaced(engine: ProbeEngine) -> None:
    assert engine.answer_request("openrois.hello", {}).error == -32601
    engine.extension = lambda method, _params: Answer({}) if method == "openrois.hello" else None
    assert result(engine.answer_request("openrois.hello", {})) == {}
    assert engine.answer_request("rois.stream.connect_stream", {}).error == -32601
    engine.answers["rois.query.query"] = SILENCE
    assert engine.answer_request("rois.query.query", {}) is SILENCE
