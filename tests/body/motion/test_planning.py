"""Ways over a floor: they keep clear of everything, and none is shorter."""

from itertools import pairwise
from math import cos, dist, hypot, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_body.messages import Floor
from openrois_body.motion.ground import MARGIN, Ground
from openrois_body.motion.planning import NoWay, Policy, angle, length, plan, seconds

from tests.support.floors import SQUARE, Point, floors, metres, points, rectangle, room_along

pytestmark = pytest.mark.extra(name="body")

RADIUS = 0.25
WALL = rectangle(-0.1, -5, 0.1, 5)
POLICIES: tuple[Policy, ...] = ("distance", "time")


def ground(*obstacles: tuple[Point, ...]) -> Ground:
    return Ground(Floor(SQUARE, obstacles), RADIUS)


@pytest.mark.parametrize("policy", POLICIES)
def test_without_a_floor_the_way_is_straight(policy: Policy) -> None:
    assert plan(None, (0, 0), 0, (5_000, 1), policy) == [(5_000, 1)]


@pytest.mark.parametrize("policy", POLICIES)
def test_where_nothing_is_in_between_the_way_is_straight(policy: Policy) -> None:
    assert plan(ground(WALL), (-3, -3), 0, (-3, 3), policy) == [(-3, 3)]


@pytest.mark.parametrize("policy", POLICIES)
def test_a_wall_is_walked_round_at_the_near_end(policy: Policy) -> None:
    way = plan(ground(WALL), (-2, 4), 0, (2, 4), policy)
    assert len(way) == 3
    assert min(y for _, y in way[:2]) > 5.25
    assert length((-2, 4), way) < 5


def test_standing_where_one_wants_to_be_is_a_way() -> None:
    for policy in POLICIES:
        assert plan(ground(WALL), (-2, 4), 0, (-2, 4), policy) == [(-2, 4)]


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ((7, 0), "is outside of the floor or inside an obstacle"),
        ((0, 0), "is outside of the floor or inside an obstacle"),
        ((0.2, 0), r"is only 0\.10 m from an edge; the body needs 0\.25 m"),
        ((3, 3), "cannot be reached: obstacles are all around it"),
    ],
)
def test_unreachable_goal_is_refused_with_the_reason(goal: Point, reason: str) -> None:
    fence = rectangle(2, 2, 4, 2.1), rectangle(2, 3.9, 4, 4), rectangle(2, 2, 2.1, 4), rectangle(3.9, 2, 4, 4)
    for policy in POLICIES:
        with pytest.raises(NoWay, match=reason):
            plan(ground(WALL, *fence), (-3, -3), 0, goal, policy)


def test_a_floor_without_room_for_the_figure_is_no_way() -> None:
    narrow = Ground(Floor(rectangle(0, 0, 1, 0.4)), RADIUS)
    with pytest.raises(NoWay, match="the body has no room on this floor"):
        plan(narrow, (0.2, 0.2), 0, (0.8, 0.2), "distance")


def test_a_figure_that_stands_too_near_leaves_by_the_nearest_clear_point() -> None:
    way = plan(ground(WALL), (-0.2, 0), 0, (-3, 2), "distance")
    assert way == [pytest.approx((-0.355, 0)), (-3, 2)]


def test_a_figure_that_stands_in_a_wall_gets_out() -> None:
    assert plan(ground(WALL), (0.01, 0), 0, (3, 2), "time")[0] == pytest.approx((0.355, 0))


def test_the_fastest_way_may_be_longer_and_turns_less() -> None:
    # Between blocks the way to the corner opposite is a zigzag; along the walls there are few turns.
    here = ground(*(rectangle(x, y, x + 1, y + 1) for x in (-4, -2, 0, 2) for y in (-4, -2, 0, 2)))
    start, goal = (-5.0, -5.0), (4.0, 4.0)
    short = plan(here, start, 0, goal, "distance")
    fast = plan(here, start, 0, goal, "time")
    assert length(start, short) < length(start, fast) - 1
    assert seconds(start, 0, fast) < seconds(start, 0, short) - 0.5


def test_a_search_for_the_fastest_way_that_takes_too_long_gives_the_shortest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois_body.motion.planning._MOST_STEPS", 2)
    way = plan(ground(WALL), (-2, 4), 0, (2, 4), "time")
    assert way == plan(ground(WALL), (-2, 4), 0, (2, 4), "distance")


def test_turns_and_metres_are_what_a_way_costs() -> None:
    assert seconds((0, 0), 0, [(2, 0), (2, 0), (2, 1)]) == pytest.approx(2 + 1 + 1)
    assert seconds((0, 0), pi, [(1, 0)]) == pytest.approx(1 + 2)
    assert angle(3.0, -3.0) == pytest.approx(2 * pi - 6)


@given(floors(), points(), points(), st.floats(-pi, pi), st.sampled_from(POLICIES))
@settings(max_examples=80, deadline=None)
def test_a_way_ends_where_it_shall_and_keeps_clear_of_everything(
    floor: Floor, start: Point, goal: Point, heading: float, policy: Policy
) -> None:
    here = Ground(floor, RADIUS)
    try:
        way = plan(here, start, heading, goal, policy)
    except NoWay:
        return
    assert way[-1] == goal
    first = way if not here.clear_at(start) else [start, *way]
    assert room_along(floor, first) >= RADIUS - 1e-6


@given(floors(3), points(), points(), st.lists(points(), min_size=1, max_size=2))
@settings(max_examples=60, deadline=None)
def test_no_detour_is_shorter(floor: Floor, start: Point, goal: Point, between: list[Point]) -> None:
    detour = [start, *between, goal]
    if room_along(floor, detour) < (RADIUS + MARGIN) / cos(pi / 6):
        return
    way = plan(Ground(floor, RADIUS), start, 0, goal, "distance")
    assert metres([start, *way]) <= metres(detour) + 1e-6


@given(floors(3), points(), points(), st.floats(-pi, pi))
@settings(max_examples=60, deadline=None)
def test_the_fastest_way_is_not_slower_and_not_shorter_than_the_shortest(
    floor: Floor, start: Point, goal: Point, heading: float
) -> None:
    here = Ground(floor, RADIUS)
    try:
        short, fast = (plan(here, start, heading, goal, policy) for policy in POLICIES)
    except NoWay:
        return
    assert length(start, short) <= length(start, fast) + 1e-6
    if here.clear_at(start):
        assert seconds(start, heading, fast) <= seconds(start, heading, short) + 1e-6


def test_a_thousand_corners_are_searched_and_what_was_seen_is_kept() -> None:
    spikes = 400
    star = tuple(
        (reach * cos(2 * pi * turn / spikes), reach * sin(2 * pi * turn / spikes))
        for turn, reach in ((turn, 4.0 if turn % 2 else 3.8) for turn in range(spikes))
    )
    posts = [rectangle(x, y, x + 0.1, y + 0.1) for x in (-5.2, 5.2) for y in (-5.2, 5.2)]
    here = ground(star, *posts)
    for policy in POLICIES:
        way = plan(here, (-5.7, 0), 0, (5.7, 0), policy)
        assert length((-5.7, 0), way) < 4.3 * pi + 2.2
        assert min(hypot(*point) for point in way) >= 4.25
        assert all(dist(a, b) > 0 for a, b in pairwise(way))


CORNERS = st.tuples(st.integers(-4, 4), st.integers(-4, 4)).map(lambda corner: (corner[0] * 0.75, corner[1] * 0.75))
WILD = st.lists(CORNERS, min_size=3, max_size=6).map(tuple)


@given(WILD | st.just(SQUARE), st.lists(WILD, max_size=3), points(), points(), st.sampled_from(POLICIES))
@settings(max_examples=150, deadline=None)
def test_on_floors_that_make_no_sense_ways_keep_clear_too(
    outline: tuple[Point, ...], obstacles: list[tuple[Point, ...]], start: Point, goal: Point, policy: Policy
) -> None:
    floor = Floor(outline, tuple(obstacles))
    here = Ground(floor, RADIUS)
    try:
        way = plan(here, start, 0, goal, policy)
    except NoWay:
        return
    assert way[-1] == goal
    assert room_along(floor, way if not here.clear_at(start) else [start, *way]) >= RADIUS - 1e-6
