"""Targets as applications write them."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.messages import Thing, Things
from openrois_body.motion.targets import MAX_TARGETS, Position, read_target, read_targets
from openrois_body.motion.world import World

from openrois.errors import BadParameter

ANNA = Thing("p1", "person", 1.0, 2.0, name="Anna")


@pytest.fixture
def world() -> World:
    world = World("avatar")
    world.handle_event(Things((ANNA,)))
    return world


@pytest.mark.parametrize(
    ("text", "position"),
    [
        ("1,2", Position(1, 2)),
        (" 1.5 , -2e-1 ", Position(1.5, -0.2)),
        ("1,2,0.5", Position(1, 2, 0.5)),
        ("0,0,0", Position(0, 0, 0)),
        (f"0,0,{2.5 * math.pi}", Position(0, 0, math.pi / 2)),
    ],
)
def test_positions_are_metres_and_radians(world: World, text: str, position: Position) -> None:
    found = read_target(text, world)
    assert isinstance(found, Position)
    assert (found.x, found.y) == (position.x, position.y)
    assert found.th == (None if position.th is None else pytest.approx(position.th))


@pytest.mark.parametrize("text", ["Anna", "p1", "urn:x-rois:def:person:OpenRoIS::avatar/scene/p1"])
def test_people_and_things_are_called_by_name_id_or_ref(world: World, text: str) -> None:
    assert read_target(text, world) is ANNA


@pytest.mark.parametrize("text", ["", "1", "1,2,3,4", "1,two", "Bob", ",", "1;2"])
def test_text_that_is_neither_position_nor_thing_is_refused(world: World, text: str) -> None:
    with pytest.raises(BadParameter, match=f"{text!r} is not in the scene"):
        read_target(text, world)


@pytest.mark.parametrize("text", ["nan,0", "0,inf", "10001,0", "0,-1e9,0", "0,0,nan", "0,0,inf"])
def test_places_that_are_nowhere_are_refused(world: World, text: str) -> None:
    with pytest.raises(BadParameter, match="expected metres"):
        read_target(text, world)


@pytest.mark.parametrize("number", [0, MAX_TARGETS + 1])
def test_a_route_has_some_targets_and_not_too_many(world: World, number: int) -> None:
    with pytest.raises(BadParameter, match="expected 1 to 100 positions"):
        read_targets(("0,0",) * number, world)


def test_a_route_is_read_in_order(world: World) -> None:
    assert read_targets(("1,2",) * MAX_TARGETS, world) == (Position(1, 2),) * MAX_TARGETS
    assert read_targets(("1,2", "Anna"), world) == (Position(1, 2), ANNA)


@given(st.text(max_size=40))
def test_no_text_does_anything_but_be_read_or_refused(text: str) -> None:
    try:
        found = read_target(text, World("avatar"))
    except BadParameter:
        return
    assert isinstance(found, Position)
    assert math.isfinite(found.x + found.y + (found.th or 0))
