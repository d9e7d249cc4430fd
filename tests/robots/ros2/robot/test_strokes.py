"""The strokes of a motion, closed by the odometry."""

from math import cos, dist, inf, nan, pi, sin

import pytest
from openrois_body.messages import Place
from openrois_body.teleoperation.steering import STANDING, Velocity
from openrois_robots.ros2.robot.strokes import (
    STUCK,
    Limits,
    Stroke,
    Strokes,
    clamped,
    curve_strokes,
    line_strokes,
)

LIMITS = Limits(0.5, 1.0)
STEP = 0.02
START = Place(0, 0, 0)


def drive(strokes: list[Stroke], start: Place = START, drift: float = 0.0) -> tuple[Place, list[Velocity]]:
    """Return where a robot gets that obeys, and its velocities; `drift` turns it by itself, in rad/s."""
    motion, place, now, told = Strokes(strokes, LIMITS), start, 0.0, list[Velocity]()
    while (velocity := motion.velocity(place, now)) is not None:
        assert not motion.is_stuck(now)
        told.append(velocity)
        th = place.th + (velocity.turn + drift) * STEP
        place = Place(place.x + velocity.ahead * cos(th) * STEP, place.y + velocity.ahead * sin(th) * STEP, th)
        now += STEP
        assert now < 60
    return place, told


@pytest.mark.parametrize("start", [Place(0, 0, 0), Place(2, -1, 2.5)])
@pytest.mark.parametrize(
    ("values", "ahead", "turn"), [((800, 0), 0.8, 0), ((-400, 0), -0.4, 0), ((300, 120), 0.3, 2.094)]
)
def test_a_line_leads_ahead_and_then_turns(values: tuple[int, int], ahead: float, turn: float, start: Place) -> None:
    end, told = drive(line_strokes(values), start)
    assert dist((end.x, end.y), (start.x + ahead * cos(start.th), start.y + ahead * sin(start.th))) < 0.03
    assert end.th - start.th == pytest.approx(turn, abs=0.04)
    assert max(abs(each.ahead) for each in told) <= LIMITS.speed
    # It is slow at the end, so that it stands where it should.
    assert abs(told[-1].ahead) < 0.15


def test_more_than_a_whole_turn_is_turned() -> None:
    end, told = drive(line_strokes((0, 450)))
    assert end.th == pytest.approx(2.5 * pi, abs=0.04)
    assert max(each.turn for each in told) == LIMITS.turn


@pytest.mark.parametrize("degrees", [90, -90])
def test_a_curve_is_part_of_a_circle(degrees: int) -> None:
    end, told = drive(curve_strokes((1000, degrees)))
    side = 1 if degrees > 0 else -1
    assert dist((end.x, end.y), (1.0, side * 1.0)) < 0.06
    assert end.th == pytest.approx(side * pi / 2, abs=0.04)
    assert all(each.ahead == pytest.approx(abs(each.turn)) for each in told)


def test_a_curve_without_a_radius_is_a_turn() -> None:
    end, told = drive(curve_strokes((0, 90)))
    assert dist((end.x, end.y), (0, 0)) < 1e-9
    assert end.th == pytest.approx(pi / 2, abs=0.04)
    assert all(each.ahead == 0 for each in told)


def test_what_is_nothing_has_no_strokes() -> None:
    assert line_strokes((0, 0)) == []
    assert curve_strokes((500, 0)) == []
    assert Strokes([], LIMITS).velocity(Place(0, 0, 0), 0.0) is None


def test_a_robot_that_drifts_is_kept_on_its_line() -> None:
    end, _ = drive(line_strokes((2000, 0)), drift=0.1)
    assert abs(end.y) < 0.2
    assert end.x == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("odd", [Velocity(nan, 0.0, 0.1), Velocity(0.1, nan, 0.0), Velocity(0.1, 0.0, inf)])
def test_a_velocity_that_is_no_number_is_none(odd: Velocity) -> None:
    assert clamped(odd, Limits(0.5, 1.0)) == STANDING


def test_without_progress_it_is_stuck_and_a_rest_is_none() -> None:
    motion = Strokes(line_strokes((1000, 0)), LIMITS)
    motion.velocity(Place(0, 0, 0), 0.0)
    motion.velocity(Place(0.005, 0, 0), STUCK)
    assert not motion.is_stuck(STUCK)
    assert motion.is_stuck(STUCK + 0.1)
    assert motion.left == pytest.approx(0.995)
    motion.rest(STUCK + 0.1)
    assert not motion.is_stuck(2 * STUCK)
    assert not Strokes([], LIMITS).is_stuck(100.0)


@pytest.mark.parametrize(
    ("asked", "given"),
    [
        (Velocity(0.3, 0.0, 0.5), Velocity(0.3, 0.0, 0.5)),
        (Velocity(3.0, 4.0, -9.0), Velocity(0.3, 0.4, -1.0)),
        (STANDING, STANDING),
        (Velocity(0.0, 0.0, 9.0), Velocity(0.0, 0.0, 1.0)),
    ],
)
def test_velocities_are_within_their_limits_in_the_same_direction(asked: Velocity, given: Velocity) -> None:
    found = clamped(asked, LIMITS)
    assert (found.ahead, found.left, found.turn) == pytest.approx((given.ahead, given.left, given.turn))
