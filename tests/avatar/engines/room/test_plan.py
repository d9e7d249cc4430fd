from itertools import combinations
from math import hypot

import pytest
from openrois_avatar.engines.room.plan import HOME, PLANT, RADIO, ROOM, STOOL, TABLE, Plan, box, round_, to_edge
from openrois_avatar.link.messages import Floor, Thing, Things


def test_the_floor_is_one_that_the_link_takes() -> None:
    floor = ROOM.floor
    assert Floor.from_json(floor.to_json()) == floor
    xs, ys = zip(*floor.outline, strict=True)
    assert (min(xs), max(xs), min(ys), max(ys)) == (-3.0, 3.0, -1.0, 4.0)
    assert len(floor.obstacles) == len(ROOM.furniture) == 4


def test_all_that_stands_there_is_a_thing() -> None:
    read = Things.from_json(Things(ROOM.things).to_json())
    assert {thing.id: thing.kind for thing in read.things} == {
        "table": "object",
        "pillar": "object",
        "plant": "object",
        "stool": "object",
        "radio": "sound",
    }


def test_a_body_fits_where_nothing_is() -> None:
    assert ROOM.fits(HOME.x, HOME.y, 0.5)
    assert not ROOM.fits(TABLE.x, TABLE.y, 0.0)
    assert not ROOM.fits(TABLE.x, 1.85 - 0.2, 0.25)
    assert ROOM.fits(TABLE.x, 1.85 - 0.3, 0.25)
    assert not ROOM.fits(2.9, 0.0, 0.25)
    assert ROOM.fits(2.9, 0.0, 0.05)
    assert not ROOM.fits(0.0, 4.5, 0.1)


def test_the_home_of_the_figure_is_free_and_the_radio_is_on_the_table() -> None:
    assert ROOM.is_clear((HOME.x, HOME.y), (0.0, 3.5), 0.25)
    assert not ROOM.is_clear((HOME.x, HOME.y), (PLANT.x, PLANT.y), 0.25)
    assert ROOM.is_clear((HOME.x, HOME.y), (HOME.x, HOME.y), 0.25)
    assert not Plan(TABLE.outline, ()).fits(HOME.x, HOME.y, 0.0)
    assert Plan(TABLE.outline, ()).fits(RADIO.x, RADIO.y, 0.1)


def test_a_round_thing_has_room_for_its_circle() -> None:
    assert all(hypot(x - 1.0, y - 2.0) >= 0.5 for x, y in round_(1.0, 2.0, 0.5))
    assert STOOL.reach == pytest.approx(0.24 / 0.9239, abs=1e-3)


def test_furniture_stands_apart() -> None:
    for one, other in combinations(ROOM.furniture, 2):
        assert hypot(one.x - other.x, one.y - other.y) > one.reach + other.reach + 0.5


@pytest.mark.parametrize(("x", "y", "distance"), [(0.5, 1.0, 1.0), (-3.0, 4.0, 5.0), (2.0, 0.0, 1.0), (0.2, 0.0, 0.0)])
def test_how_far_a_point_is_from_a_line(x: float, y: float, distance: float) -> None:
    assert to_edge(x, y, (0.0, 0.0), (1.0, 0.0)) == pytest.approx(distance)


def test_a_plan_may_have_more_than_boxes() -> None:
    corner = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 2.0), (1.0, 1.0), (0.0, 1.0))
    plan = Plan(corner, (), (Thing("cat", "object", 0.5, 0.5),))
    assert plan.fits(0.5, 0.5, 0.3)
    assert not plan.fits(0.5, 1.5, 0.1)
    assert plan.fits(1.5, 1.5, 0.3)
    assert [thing.id for thing in plan.things] == ["cat"]
    assert box(0.0, 0.0, 2.0, 4.0) == ((-1.0, -2.0), (1.0, -2.0), (1.0, 2.0), (-1.0, 2.0))
