"""Lines and curves: where they end, and how far from the circle their points are."""

from math import cos, dist, nan, pi, radians, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.messages import Place, Waypoint
from openrois_body.motion.legs import TOP_SPEED
from openrois_body.motion.moves import curve, curve_length, line, speed_for
from openrois_body.motion.planning import SPEED, angle

from openrois.errors import BadParameter

NORTH = Place(1.0, 2.0, pi / 2)


def numbers(path: list[Waypoint]) -> list[float]:
    return [number for at in path for number in (at.x, at.y, nan if at.th is None else at.th)]


def test_a_line_goes_ahead_and_then_turns_left() -> None:
    assert numbers(line(NORTH, (1500, 90))) == pytest.approx([1, 3.5, nan, 1, 3.5, pi], nan_ok=True)


def test_a_negative_line_goes_backwards_and_keeps_looking_ahead() -> None:
    assert numbers(line(NORTH, (-600, 0))) == pytest.approx([1, 1.7, pi / 2, 1, 1.4, pi / 2])


def test_a_turn_of_more_than_half_a_turn_goes_the_way_that_was_said() -> None:
    turns = [at.th or 0.0 for at in line(NORTH, (0, -270))]
    assert turns == pytest.approx([0, -pi / 2, -pi])
    assert [at.th for at in curve(NORTH, (0, 360))] == pytest.approx([pi, -pi / 2, 0, pi / 2])


def test_nothing_to_go_is_a_path_of_one_point() -> None:
    here = [Waypoint(1.0, 2.0, pi / 2)]
    assert line(NORTH, (0, 0)) == curve(NORTH, (0, 0)) == curve(NORTH, (500, 0)) == here


@given(st.integers(1, 5_000), st.integers(-720, 720).filter(bool), st.floats(-pi, pi))
def test_a_curve_stays_on_its_circle(radius: int, degrees: int, heading: float) -> None:
    start = Place(1.0, 2.0, heading)
    path = curve(start, (radius, degrees))
    metres = radius / 1000
    side = pi / 2 if degrees > 0 else -pi / 2
    centre = start.x + metres * cos(heading + side), start.y + metres * sin(heading + side)
    points = [(start.x, start.y), *((at.x, at.y) for at in path)]
    assert [dist(point, centre) for point in points] == pytest.approx([metres] * len(points))
    assert max(map(dist, points, points[1:])) <= metres * radians(10) + 1e-9
    assert angle(path[-1].th or 0.0, heading + radians(degrees)) < 1e-6
    assert curve_length((radius, degrees)) == pytest.approx(metres * radians(abs(degrees)))


@pytest.mark.parametrize("values", [(), (1,), (1, 2, 3)])
def test_two_numbers_are_expected(values: tuple[int, ...]) -> None:
    for move in (line, curve):
        with pytest.raises(BadParameter, match="expected two numbers, millimetres and degrees"):
            move(NORTH, values)


@pytest.mark.parametrize(
    ("values", "why"),
    [((10_000_001, 0), "at most 10000000 mm"), ((0, 3601), "at most 3600 degrees"), ((0, -3601), "not -3601")],
)
def test_too_large_value_is_refused(values: tuple[int, int], why: str) -> None:
    for move in (line, curve):
        with pytest.raises(BadParameter, match=why):
            move(NORTH, values)


def test_a_way_that_no_engine_can_be_told_is_refused() -> None:
    assert len(line(NORTH, (-400_000, 0))) == 1000
    with pytest.raises(BadParameter, match="line: the way has 1001 steps, and at most 1000 are possible"):
        line(NORTH, (-400_001, 0))
    with pytest.raises(BadParameter, match="curve: the way leads beyond 10000 m"):
        curve(NORTH, (6_000_000, 180))


def test_a_radius_is_not_negative() -> None:
    with pytest.raises(BadParameter, match="the radius must be 0 mm or more, not -5"):
        curve(NORTH, (-5, 90))


def test_a_time_sets_the_speed() -> None:
    assert speed_for(-3.0, 2_000, TOP_SPEED) == 1.5
    assert speed_for(3.0, None, TOP_SPEED) == speed_for(3.0, 0, TOP_SPEED) == speed_for(0.0, 5, TOP_SPEED) == SPEED
    assert speed_for(TOP_SPEED, 1_000, TOP_SPEED) == TOP_SPEED


@pytest.mark.parametrize(("metres", "time"), [(3.0, 1_000), (0.001, 1_000)])
def test_too_fast_or_too_slow_motion_is_refused(metres: float, time: int) -> None:
    with pytest.raises(BadParameter, match=r"time: .* the speed must be between 0\.01 and 2 m/s"):
        speed_for(metres, time, TOP_SPEED)
