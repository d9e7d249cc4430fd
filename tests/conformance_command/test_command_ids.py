"""The ids of commands as a check writes them, and as they are sent."""

from typing import Any

import pytest
from openrois_conformance.command_ids import CommandIds

pytestmark = pytest.mark.extra(name="base")


def units(*command_ids: Any) -> dict[str, Any]:
    return {"command_unit_list": [{"command_id": each} for each in command_ids]}


def test_each_is_another_on_the_wire_and_comes_back_as_it_was() -> None:
    ids, others = CommandIds(), CommandIds()
    sent = ids.outgoing({"command_unit_list": [{"command_list": [{"command_id": "a"}]}, {"command_id": "a"}]})
    (branch, single) = sent["command_unit_list"]
    assert branch["command_list"] == [single]
    assert single["command_id"] == ids.sent("a") != others.outgoing(units("a"))["command_unit_list"][0]["command_id"]
    assert ids.incoming({"command_id": ids.sent("a"), "status": "OK"}) == {"command_id": "a", "status": "OK"}
    assert ids.incoming({"forgotten": [ids.sent("a"), "x"]}) == {"forgotten": ["a", "x"]}
    assert ids.outgoing({"command_id": "a"}) == {"command_id": ids.sent("a")}
    assert ids.outgoing({"command_ids": ["a", "x"]}) == {"command_ids": [ids.sent("a"), "x"]}


@pytest.mark.parametrize(
    "params",
    [
        units("", 5, None),
        {"command_unit_list": ["a", 5, {"component_ref": "x"}, {"command_list": "a"}]},
        {"command_unit_list": 5, "command_id": 5, "command_ids": 5},
        {"command_id": "never sent"},
        {},
    ],
)
def test_what_is_none_is_kept(params: dict[str, Any]) -> None:
    ids = CommandIds()
    assert ids.outgoing(params) == params
    assert ids.incoming({"command_id": "x", "forgotten": 5}) == {"command_id": "x", "forgotten": 5}
