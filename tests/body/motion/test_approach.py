"""Getting near something, and how far a path is open."""

from math import dist

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_body.messages import Floor
from openrois_body.motion.approach import approach, check_path
from openrois_body.motion.ground import Ground
from openrois_body.motion.planning import NoWay

from openrois.errors import ComponentFailed
from tests.support.floors import SQUARE, Point, floors, points, rectangle, room_along

RADIUS = 0.25
WALL = rectangle(-0.1, -5, 0.1, 5)
ROOM = Floor(SQUARE, (WALL,))
GROUND = Ground(ROOM, RADIUS)


def test_way_ends_at_the_distance() -> None:
    for ground in (None, GROUND):
        assert approach(ground, (-4, 0), 0, (-1, 0), 1.0, "distance") == [pytest.approx((-2, 0), abs=1e-3)]


def test_figure_near_enough_stays() -> None:
    assert approach(None, (0, 0), 0, (1, 0), 1.0, "time") == []
    assert approach(GROUND, (-2, 0), 0, (-1.5, 0), 1.0, "time") == []


def test_near_behind_a_wall_is_not_near() -> None:
    way = approach(GROUND, (-0.5, 4), 0, (0.5, 4), 1.5, "distance")
    assert way
    assert way[-1][1] > 4.9


def test_target_in_a_wall_is_approached_to_the_nearest_point() -> None:
    assert approach(GROUND, (-3, 0), 0, (-0.05, 0), 0.2, "distance") == [pytest.approx((-0.355, 0))]


@pytest.mark.parametrize("start", [(-4, 1), (-4, -4), (0.5, -4), (-1.9, 1.2)])
def test_furniture_does_not_hide_itself(start: Point) -> None:
    stool = rectangle(-2.2, -0.2, -1.8, 0.2)
    ground = Ground(Floor(SQUARE, (stool,)), RADIUS)
    assert dist(approach(ground, start, 0, (-2, 0), 0.7, "distance")[-1], (-2, 0)) == pytest.approx(0.7, abs=1e-3)
    behind = Ground(Floor(SQUARE, (stool, rectangle(-2.6, -5, -2.5, 4))), RADIUS)
    assert approach(behind, (-2.9, 0), 0, (-2, 0), 0.95, "distance")[-1][0] > -2.5


def test_where_there_is_no_room_there_is_no_way() -> None:
    with pytest.raises(NoWay, match="no room on this floor"):
        approach(Ground(Floor(rectangle(0, 0, 0.4, 0.4)), RADIUS), (0, 0), 0, (0.3, 0.3), 0.1, "time")


@given(floors(2), points(), points(), st.floats(0.1, 3.0))
@settings(max_examples=40, deadline=None)
def test_the_way_keeps_clear_and_ends_near(floor: Floor, start: Point, centre: Point, metres: float) -> None:
    ground = Ground(floor, RADIUS)
    if not (ground.clear_at(start) and ground.clear_at(centre)):
        return
    try:
        way = approach(ground, start, 0, centre, metres, "distance")
    except NoWay:
        return
    assert room_along(floor, [start, *way]) >= RADIUS - 1e-6
    assert dist([start, *way][-1], centre) <= metres + 1e-6


def test_an_open_path_passes() -> None:
    check_path(ROOM, GROUND, (-3, 0), [(-3, 4), (-0.5, 4)])


@pytest.mark.parametrize(
    ("path", "metres"), [([(3, 0)], "2.6"), ([(-3, 2), (3, 2)], "4.6"), ([(-0.2, 0)], "2.6"), ([(-7, 0)], "2.7")]
)
def test_obstacle_is_reported_with_its_distance(path: list[Point], metres: str) -> None:
    with pytest.raises(ComponentFailed, match=rf"an obstacle is in the way after {metres}"):
        check_path(ROOM, GROUND, (-3, 0), path)


def test_figure_too_near_may_go_where_it_does_not_come_nearer() -> None:
    check_path(ROOM, GROUND, (-0.2, 0), [(-0.2, 3)])
    check_path(ROOM, GROUND, (-0.2, 0), [(-2, 0)])
    with pytest.raises(ComponentFailed, match=r"in the way after 0\.0"):
        check_path(ROOM, GROUND, (-0.2, 0), [(0.2, 0)])


@pytest.mark.parametrize("start", [(0, 0), (9, 9), (-0.103, 0)])
def test_figure_in_an_obstacle_cannot_go_straight(start: Point) -> None:
    with pytest.raises(ComponentFailed, match="stands in an obstacle"):
        check_path(ROOM, GROUND, start, [(-3, 0)])
