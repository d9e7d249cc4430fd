from math import isclose

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.teleoperation.steering import STANDING, Steering, Velocity, pace, shaped
from openrois_streaming.input.messages import NOTHING, Gamepad, Held, Pointer, Touch

from tests.support.input import HELD

STEERING = Steering(max_speed=2.0, max_turn=3.0, dead_zone=0.2, expo=0.5)


def keys(*codes: str) -> Held:
    return Held(frozenset(codes))


def stick(x: float = 0, y: float = 0, right_x: float = 0, right_y: float = 0) -> Held:
    return Held(gamepad=Gamepad((x, y, right_x, right_y)))


def pressed(*indices: int) -> Held:
    return Held(gamepad=Gamepad(buttons=tuple(float(index in indices) for index in range(17))))


@pytest.mark.parametrize(
    ("held", "velocity"),
    [
        (NOTHING, STANDING),
        (keys("KeyX"), STANDING),
        (keys("KeyW"), Velocity(ahead=2)),
        (keys("ArrowDown"), Velocity(ahead=-2)),
        (keys("KeyW", "ArrowUp"), Velocity(ahead=2)),
        (keys("KeyW", "KeyS"), STANDING),
        (keys("KeyA"), Velocity(turn=3)),
        (keys("ArrowRight", "KeyW"), Velocity(ahead=2, turn=-3)),
        (keys("KeyQ"), Velocity(left=1)),
        (keys("KeyE"), Velocity(left=-1)),
        (stick(y=-1), Velocity(ahead=2)),
        (stick(x=-1), Velocity(turn=3)),
        (stick(x=0.2, y=-0.2), STANDING),
        (Held(frozenset({"KeyS"}), gamepad=Gamepad((0, -1))), STANDING),
        (Held(frozenset({"KeyW"}), gamepad=Gamepad((0, -1))), Velocity(ahead=2)),
        (pressed(12), Velocity(ahead=2)),
        (pressed(13, 14), Velocity(ahead=-2, turn=3)),
        (pressed(15, 4), Velocity(left=1, turn=-3)),
        (pressed(5, 4), STANDING),
        (stick(right_x=1, right_y=1), STANDING),
    ],
)
def test_where_it_goes(held: Held, velocity: Velocity) -> None:
    assert STEERING.velocity(held) == velocity


@pytest.mark.parametrize(
    ("held", "gaze"),
    [
        (NOTHING, None),
        (keys("KeyW"), None),
        (Held(pointer=Pointer(0, 0)), (-1, 1)),
        (Held(pointer=Pointer(0.75, 0.5)), (0.5, 0)),
        (Held(pointer=Pointer(0, 0), touches=(Touch(3, 1, 1), Touch(4, 0, 0))), (1, -1)),
        (stick(x=1, y=1), None),
        (stick(right_x=-1, right_y=-1), (-1, 1)),
        (Held(pointer=Pointer(0, 0), gamepad=Gamepad((0, 0, 0, 1))), (0, -1)),
    ],
)
def test_where_it_looks(held: Held, gaze: tuple[float, float] | None) -> None:
    assert STEERING.gaze(held) == gaze


def test_a_stick_begins_at_nothing_behind_its_dead_zone_and_ends_at_all() -> None:
    assert shaped(0.2, 0.2, 0.5) == 0
    assert 0 < shaped(0.21, 0.2, 0.5) < 0.01
    assert (shaped(1.0, 0.2, 0.5), shaped(-1.0, 0.2, 0.5), shaped(1.5, 0.2, 0.5)) == (1, -1, 1)
    assert isclose(shaped(0.6, 0.2, 0), 0.5)
    assert isclose(shaped(0.6, 0.2, 1), 0.125)


@given(st.floats(-1, 1), st.floats(0, 0.9), st.floats(0, 1))
def test_further_never_asks_for_less(deflection: float, dead_zone: float, expo: float) -> None:
    asked = shaped(deflection, dead_zone, expo)
    assert asked == -shaped(-deflection, dead_zone, expo)
    assert -1 <= asked <= 1
    assert abs(shaped(deflection * 0.9, dead_zone, expo)) <= abs(asked)


@given(HELD)
def test_whatever_is_held_stays_within_the_limits(held: Held) -> None:
    velocity = STEERING.velocity(held)
    assert abs(velocity.ahead) <= 2
    assert abs(velocity.left) <= 1
    assert abs(velocity.turn) <= 3
    for each in STEERING.gaze(held) or ():
        assert -1 <= each <= 1


@pytest.mark.parametrize(("round_trip", "share"), [(0.0, 1.0), (0.5, 1.0), (1.0, 0.5), (5.0, 0.1)])
def test_body_goes_slower_where_the_round_trip_is_long(round_trip: float, share: float) -> None:
    assert pace(round_trip) == pytest.approx(share)
    slower = Steering(max_speed=2.0, max_turn=1.0).at(pace(round_trip))
    assert (slower.max_speed, slower.max_turn) == pytest.approx((2.0 * share, 1.0 * share))
