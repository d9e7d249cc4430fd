"""What is known of the scene: the last report of the engine, until it is gone."""

import pytest
from openrois_body.messages import Floor, Log, Place, Thing, Things
from openrois_body.motion.world import World, thing_ref

from openrois.errors import BadParameter

SQUARE = Floor(((-2, -2), (2, -2), (2, 2), (-2, 2)))
ANNA = Thing("p1", "person", 1.0, 2.0, name="Anna")
TABLE = Thing("t", "object", 0.0, 2.0)


@pytest.fixture
def world() -> World:
    return World("avatar")


def test_world_has_the_last_report_and_announces_it(world: World) -> None:
    told: list[object] = []
    world.changed.add(told.append)
    events = (Place(0, 0, -1.5), SQUARE, Things((ANNA,)), Place(1, 0, 0), Things((ANNA, TABLE)))
    for event in events:
        world.handle_event(event)
    world.handle_event(Log("a line"))
    assert told == list(events)
    assert (world.place, world.floor, world.things) == (Place(1, 0, 0), SQUARE, (ANNA, TABLE))


def test_repeated_report_is_not_announced(world: World) -> None:
    told: list[object] = []
    events = (Place(0, 0, 0), SQUARE, Things((ANNA,)))
    for event in events:
        world.handle_event(event)
    known = world.floor
    world.changed.add(told.append)
    for event in (Place(0, 0, 0), Floor(SQUARE.outline, ()), Things((Thing("p1", "person", 1.0, 2.0, name="Anna"),))):
        world.handle_event(event)
    assert told == []
    assert world.floor is known


def test_a_lost_engine_takes_its_scene_along(world: World) -> None:
    for event in (Place(0, 0, 0), SQUARE, Things((ANNA,))):
        world.handle_event(event)
    told: list[object] = []
    world.changed.add(told.append)
    world.clear()
    assert told == [None]
    assert (world.place, world.floor, world.things) == (None, None, ())


def test_things_are_found_by_ref_id_and_name(world: World) -> None:
    world.handle_event(Things((ANNA, TABLE)))
    assert world.ref(ANNA) == thing_ref("avatar", ANNA) == "urn:x-rois:def:person:OpenRoIS::avatar/scene/p1"
    assert [world.find(called) for called in (world.ref(ANNA), "p1", "Anna", "t")] == [ANNA, ANNA, ANNA, TABLE]


def test_an_id_comes_before_a_name(world: World) -> None:
    other = Thing("Anna", "person", 0, 0)
    world.handle_event(Things((ANNA, other)))
    assert world.find("Anna") is other


def test_missing_thing_is_refused_with_a_list_of_things(world: World) -> None:
    with pytest.raises(BadParameter, match="'Anna' is not in the scene; there is nothing"):
        world.find("Anna")
    world.handle_event(Things((ANNA, TABLE)))
    with pytest.raises(BadParameter, match="'Bob' is not in the scene; there is 'Anna', 't'"):
        world.find("Bob")
    with pytest.raises(BadParameter, match=r"^'' is not in the scene"):
        world.find("")


def test_a_name_that_several_have_is_refused(world: World) -> None:
    world.handle_event(Things((ANNA, Thing("p2", "person", 0, 0, name="Anna"))))
    with pytest.raises(BadParameter, match="'Anna' is the name of 2 things"):
        world.find("Anna")
