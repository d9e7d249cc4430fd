"""Models of the base wire are as strict as the wire: nothing unknown, nothing converted, defaults on failure."""

from typing import Any

import pytest
from pydantic import ValidationError

from openrois.types import messages
from openrois.types.codes import CompletedStatus, ReturnCode
from openrois.types.messages import (
    Argument,
    CommandUnit,
    Completed,
    ConcurrentCommands,
    EventNotification,
    ExecuteParams,
    ParametersResult,
    ProfileResult,
    QueryParams,
    ReferenceResult,
    Result,
    ResultsResult,
    ReturnResult,
    SearchResult,
    SetParameterParams,
    SetParameterResult,
    SubscribeResult,
)
from openrois.types.model import Model
from openrois.types.profiles import HRIEngineProfile, RoISIdentifier

UNIT: dict[str, Any] = {"component_ref": "r/lamp", "command_type": "switch", "command_id": "c1"}
VALUE = {"name": "n", "data_type_ref": "string", "value": "v"}


def problems(model: type[Model], params: dict[str, Any]) -> set[str]:
    """Return the dotted paths at which `params` do not fit."""
    with pytest.raises(ValidationError) as raised:
        model.model_validate(params)
    return {".".join(str(part) for part in entry["loc"]) for entry in raised.value.errors()}


def test_every_model_is_frozen_strict_and_closed() -> None:
    for name in messages.__all__:
        model = getattr(messages, name)
        if isinstance(model, type) and issubclass(model, Model):
            assert model.model_config.items() >= Model.model_config.items(), name


def test_a_model_cannot_be_changed() -> None:
    with pytest.raises(ValidationError):
        Result(**VALUE).name = "other"  # type: ignore[misc]


@pytest.mark.parametrize(
    ("params", "paths"),
    [
        ({}, {"query_type"}),
        ({"query_type": 5}, {"query_type"}),
        ({"query_type": "q", "condition": None}, {"condition"}),
        ({"query_type": "q", "component_ref": "x"}, {"component_ref"}),
    ],
)
def test_params_of_query(params: dict[str, Any], paths: set[str]) -> None:
    assert problems(QueryParams, params) == paths


def test_condition_defaults_to_empty() -> None:
    assert QueryParams.model_validate({"query_type": "q"}).condition == ""


class TestExecute:
    def test_both_forms_are_read(self) -> None:
        params = ExecuteParams.model_validate(
            {
                "command_unit_list": [
                    {**UNIT, "arguments": [VALUE], "delay_time": 20},
                    {"command_list": [UNIT, {**UNIT, "delay_time": None}], "delay_time": None},
                ]
            }
        )
        first, second = params.command_unit_list
        assert first == CommandUnit(**UNIT, arguments=(Argument(**VALUE),), delay_time=20)
        assert second == ConcurrentCommands(command_list=(CommandUnit(**UNIT), CommandUnit(**UNIT)))
        assert ExecuteParams(command_unit_list=(first, second)) == params

    @pytest.mark.parametrize(
        ("items", "paths"),
        [
            ([], {"command_unit_list"}),
            (None, {"command_unit_list"}),
            ({}, {"command_unit_list"}),
            ([UNIT] * 257, {"command_unit_list"}),
            ([5], {"command_unit_list.0"}),
            ([UNIT, {**UNIT, "x": 1}], {"command_unit_list.1.x"}),
            ([{**UNIT, "command_id": 5}], {"command_unit_list.0.command_id"}),
            ([{"component_ref": "r"}], {"command_unit_list.0.command_type", "command_unit_list.0.command_id"}),
            ([{**UNIT, "arguments": None}], {"command_unit_list.0.arguments"}),
            ([{**UNIT, "arguments": [{**VALUE, "value": 1}]}], {"command_unit_list.0.arguments.0.value"}),
            ([{"command_list": [{**UNIT, "command_type": 1}]}], {"command_unit_list.0.command_list.0.command_type"}),
            ([{"command_list": None}], {"command_unit_list.0.command_list"}),
            ([{**UNIT, "command_list": []}], {f"command_unit_list.0.{name}" for name in UNIT}),
        ],
    )
    def test_misfits_are_named_by_their_path_in_the_params(self, items: Any, paths: set[str]) -> None:
        assert problems(ExecuteParams, {"command_unit_list": items}) == paths

    @pytest.mark.parametrize("delay", ["20", 20.0, True, -1, 86_400_001, 1e300])
    def test_a_delay_is_a_whole_number_of_milliseconds_of_a_day_at_most(self, delay: Any) -> None:
        for item in ({**UNIT, "delay_time": delay}, {"command_list": [UNIT], "delay_time": delay}):
            assert problems(ExecuteParams, {"command_unit_list": [item]}) == {"command_unit_list.0.delay_time"}

    def test_it_is_written_as_it_was_read(self) -> None:
        unit = {**UNIT, "arguments": [VALUE], "delay_time": 20}
        params = {"command_unit_list": [unit, {"command_list": [unit], "delay_time": None}]}
        assert ExecuteParams.model_validate(params).model_dump(mode="json") == params

    def test_its_schema_shows_both_forms(self) -> None:
        items = ExecuteParams.model_json_schema()["properties"]["command_unit_list"]["items"]
        assert len(items["anyOf"]) == 2


def test_set_parameter_takes_an_empty_list_and_no_null() -> None:
    assert SetParameterParams.model_validate({"component_ref": "r", "parameters": []}).parameters == ()
    assert problems(SetParameterParams, {"component_ref": "r", "parameters": None}) == {"parameters"}
    assert problems(SetParameterParams, {"component_ref": "r"}) == {"parameters"}


@pytest.mark.parametrize(
    ("model", "defaults"),
    [
        (ReturnResult, {}),
        (ProfileResult, {"profile": None, "component_profiles": {}}),
        (SearchResult, {"component_ref_list": []}),
        (ReferenceResult, {"component_ref": ""}),
        (ParametersResult, {"parameters": []}),
        (SetParameterResult, {"command_id": ""}),
        (ResultsResult, {"results": []}),
        (SubscribeResult, {"subscribe_id": ""}),
    ],
)
def test_a_failure_carries_every_field_with_its_default(model: type[ReturnResult], defaults: dict[str, Any]) -> None:
    for code in ReturnCode:
        written = model(return_code=code).model_dump(mode="json")
        assert written == {"return_code": code.value, **defaults}
        assert model.model_validate(written).return_code is code


@pytest.mark.parametrize("code", ["ok", 0, None, "FINE"])
def test_a_return_code_is_a_name(code: Any) -> None:
    assert problems(ReturnResult, {"return_code": code}) == {"return_code"}


@pytest.mark.parametrize(
    ("model", "params", "path"),
    [
        (SearchResult, {"component_ref_list": [1]}, "component_ref_list.0"),
        (SearchResult, {"component_ref_list": "r"}, "component_ref_list"),
        (ResultsResult, {"results": None}, "results"),
        (ResultsResult, {"results": [{"name": "n", "data_type_ref": "int", "value": 1}]}, "results.0.value"),
        (ProfileResult, {"component_profiles": None}, "component_profiles"),
        (SubscribeResult, {"subscribe_id": None}, "subscribe_id"),
    ],
)
def test_results_of_an_adapter_are_read_as_strictly(model: type[Model], params: dict[str, Any], path: str) -> None:
    assert problems(model, params) == {path}


def test_off_the_wire_a_result_has_its_return_code() -> None:
    assert SubscribeResult.read({"return_code": "OK", "subscribe_id": "s"}) == SubscribeResult(subscribe_id="s")
    results: tuple[Any, ...] = ({"subscribe_id": "s"}, {}, [], None, "OK")
    for result in results:
        with pytest.raises(ValidationError):
            SubscribeResult.read(result)


def test_notifications() -> None:
    assert Completed.model_validate({"command_id": "c", "status": "ABORT"}).status is CompletedStatus.ABORT
    assert problems(Completed, {"command_id": "c", "status": "DONE"}) == {"status"}
    event = EventNotification.model_validate({"event_id": "e", "event_type": "t", "subscribe_id": "s"})
    assert event.model_dump(mode="json") == {
        "event_id": "e",
        "event_type": "t",
        "subscribe_id": "s",
        "expire": "",
        "results": [],
    }


def test_an_engine_profile_stands_in_a_result_as_an_object() -> None:
    written = ProfileResult(profile=HRIEngineProfile(identifier=RoISIdentifier(code="g"))).model_dump(mode="json")
    assert written["profile"]["identifier"] == {"code": "g", "authority": "", "codebook_ref": "", "version": ""}


WRONG: list[Any] = [{}] * 20_000


@pytest.mark.parametrize(
    ("model", "params"),
    [
        (ExecuteParams, {"command_unit_list": WRONG}),
        (ExecuteParams, {"command_unit_list": [{"command_list": WRONG}]}),
        (ExecuteParams, {"command_unit_list": [{**UNIT, "arguments": WRONG}]}),
        (SetParameterParams, {"component_ref": "r/lamp", "parameters": WRONG}),
        (ResultsResult, {"return_code": "OK", "results": WRONG}),
        (SearchResult, {"return_code": "OK", "component_ref_list": WRONG}),
        (ProfileResult, {"return_code": "OK", "profile": {"identifier": {"code": "r"}, "sub_profiles": WRONG}}),
        (ProfileResult, {"return_code": "OK", "component_profiles": {str(number): {} for number in range(20_000)}}),
    ],
)
def test_of_very_much_that_is_wrong_little_is_told(model: type[Model], params: dict[str, Any]) -> None:
    """One message of 64 KiB with 63,000 flaws took half a second, and one of 1 MiB twelve."""
    assert len(problems(model, params)) < 10


def test_the_profile_that_does_not_fit_is_named() -> None:
    profile = {"identifier": {"code": "x"}, "name": "lamp"}
    assert problems(ProfileResult, {"component_profiles": {"r/a": profile, "r/b": {**profile, "name": 1}}}) == {
        "component_profiles.r/b.name"
    }
    assert problems(ProfileResult, {"component_profiles": []}) == {"component_profiles"}
