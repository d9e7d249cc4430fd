"""A floor as a round body sees it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_body.messages import Floor
from openrois_body.motion.ground import MARGIN, Ground

from tests.support.floors import SQUARE, Point, floors, points, rectangle, room_along, room_at

RADIUS = 0.25
BOX = rectangle(-1, -1, 1, 1)
WITH_BOX = Ground(Floor(SQUARE, (BOX,)), RADIUS)


def array(*places: Point) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.asarray(places, dtype=np.float64)


@pytest.mark.parametrize(
    ("point", "inside", "clear"),
    [
        ((0, 0), False, False),
        ((1.2, 0), True, False),
        ((1.25, 0), True, True),
        ((5.8, 0), True, False),
        ((7, 0), False, False),
        ((1.15, 1.15), True, False),
        ((1.2, 1.2), True, True),
    ],
)
def test_points_are_clear_where_the_body_has_room(point: Point, inside: bool, clear: bool) -> None:
    assert bool(WITH_BOX.inside(array(point))[0]) is inside
    assert bool(WITH_BOX.clear(array(point))[0]) is clear


@pytest.mark.parametrize(
    ("start", "end", "is_open", "seen"),
    [
        ((-3, 0), (3, 0), False, False),
        ((-3, 2), (3, 2), True, True),
        ((-3, 1.2), (3, 1.2), False, True),
        ((-3, 0), (-3, 0), True, True),
        ((-3, 0), (-1.3, 0), True, True),
        ((-3, 0.9), (-0.9, 3), True, True),
        ((-1.8, 0.5), (-0.5, 1.8), False, True),
    ],
)
def test_ways_are_open_where_no_edge_is_too_near(start: Point, end: Point, is_open: bool, seen: bool) -> None:
    assert bool(WITH_BOX.open(array(start)[0], array(end))[0]) is is_open
    assert bool(WITH_BOX.sees(array(start)[0], array(end))[0]) is seen


def test_a_square_corner_is_passed_over_two_points() -> None:
    assert len(WITH_BOX.bends) == 8
    assert WITH_BOX.distances(WITH_BOX.bends).min() >= RADIUS + MARGIN - 1e-9
    assert np.abs(WITH_BOX.bends).max() < 1.3


@pytest.mark.parametrize(
    "obstacle",
    [((1, 1), (1, 1), (1, 1)), ((0, 1), (2, 1), (0, 1)), ((0, 0), (1, 1), (1, 0), (0, 1))],
    ids=["a point", "a line", "a figure of eight"],
)
def test_odd_obstacles_are_passed_round(obstacle: tuple[Point, ...]) -> None:
    ground = Ground(Floor(SQUARE, (obstacle,)), RADIUS)
    assert not ground.clear(array((1, 1)))[0]
    assert not ground.open(array((1, -1))[0], array((1, 3)))[0]
    assert len(ground.bends) >= 6


def test_a_way_of_no_length_is_open() -> None:
    least = 2.0788208382018698e-64
    start, end = array((0, least), (least, 0))
    assert Ground(Floor(SQUARE, ()), RADIUS).open(start, end[None])[0]


@given(floors(), points(), points())
@settings(max_examples=80, deadline=None)
def test_open_way_has_room_all_along(floor: Floor, start: Point, end: Point) -> None:
    ground = Ground(floor, RADIUS)
    assert bool(ground.clear(array(start))[0]) is (room_at(floor, start) >= RADIUS)
    if ground.clear(array(start, end)).all():
        room = room_along(floor, (start, end))
        is_open = bool(ground.open(array(start)[0], array(end))[0])
        assert room >= RADIUS - 1e-6 if is_open else room < RADIUS + 0.01


@given(floors(), points())
@settings(max_examples=50, deadline=None)
def test_the_nearest_clear_point_is_clear(floor: Floor, point: Point) -> None:
    nearest = Ground(floor, RADIUS).nearest_clear(array(point)[0])
    if nearest is not None:
        assert room_at(floor, (float(nearest[0]), float(nearest[1]))) >= RADIUS - 1e-9
        if room_at(floor, point) >= RADIUS:
            assert tuple(nearest) == point


@pytest.mark.parametrize(
    ("point", "nearest"), [((0, 0.5), (0, 1.255)), ((3, 5.9), (3, 5.745)), ((9, 0), (5.745, 0)), ((1, 0), (1.255, 0))]
)
def test_nearest_clear_point_is_found_for_a_figure_too_near(point: Point, nearest: Point) -> None:
    found = WITH_BOX.nearest_clear(array(point)[0])
    assert found == pytest.approx(nearest)


def test_where_there_is_no_room_there_is_no_clear_point() -> None:
    assert Ground(Floor(rectangle(0, 0, 0.4, 0.4)), RADIUS).nearest_clear(array((0.2, 0.2))[0]) is None


@given(st.data())
@settings(max_examples=20, deadline=None)
def test_orientation_of_a_polygon_does_not_matter(data: st.DataObject) -> None:
    floor = data.draw(floors(2))
    turned = Floor(floor.outline[::-1], tuple(each[::-1] for each in floor.obstacles))
    one, other = Ground(floor, RADIUS), Ground(turned, RADIUS)
    place = data.draw(points())
    assert one.clear(array(place)) == other.clear(array(place))
    assert len(one.bends) == len(other.bends)
