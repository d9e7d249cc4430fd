"""The engine that a request is about."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrois.auth.principal import ALLOWED
from openrois.federation.destinations import (
    MOST_UNITS,
    OF_ENGINE,
    command_ids,
    engine_named,
    engines_commanded,
    only_stops,
)


def unit(ref: object = "robot/lamp", kind: object = "start", command_id: object = "1") -> dict[str, object]:
    return {"component_ref": ref, "command_type": kind, "command_id": command_id}


def test_every_method_that_leads_to_an_engine_exists() -> None:
    assert ALLOWED.keys() >= OF_ENGINE.keys()


@pytest.mark.parametrize("method", OF_ENGINE)
def test_an_id_names_its_engine(method: str) -> None:
    assert engine_named(method, {OF_ENGINE[method]: "robot/1"}) == "robot"
    assert engine_named(method, {}) == engine_named(method, {OF_ENGINE[method]: 7}) == ""


def test_a_sequence_names_the_engines_of_all_its_commands() -> None:
    concurrent = {"command_list": [unit("arm/hand", command_id="2"), unit(7, command_id=8)]}
    params = {"command_unit_list": [unit(), concurrent, {"delay_time": 5}, "nonsense"]}
    assert engines_commanded(params) == {"robot", "arm"}
    assert command_ids(params) == {"1": "robot/lamp", "2": "arm/hand"}
    assert engines_commanded({}) == engines_commanded({"command_unit_list": 7}) == frozenset()


def test_of_a_long_sequence_the_first_commands_count() -> None:
    params = {"command_unit_list": [unit()] * MOST_UNITS + [unit("late/one", "stop", "2")]}
    assert engines_commanded(params) == {"robot"}
    assert not only_stops({"command_unit_list": [unit(kind="stop")] * (MOST_UNITS + 1)})


def test_stops_alone_are_urgent() -> None:
    assert only_stops({"command_unit_list": [unit(kind="stop")] * 2})
    assert not only_stops({"command_unit_list": [unit(kind="stop"), unit()]})
    assert not only_stops({"command_unit_list": [unit(kind=7)]})
    assert not only_stops({"command_unit_list": []})


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=15), inner, max_size=4),
    max_leaves=12,
)


@given(st.dictionaries(st.sampled_from(["command_unit_list", "component_ref", "x"]), ANYTHING))
def test_params_of_any_shape_are_read(params: dict[str, Any]) -> None:
    for engine_id in engines_commanded(params):
        assert isinstance(engine_id, str)
    only_stops(params)
    command_ids(params)
    engine_named("rois.command.bind", params)
