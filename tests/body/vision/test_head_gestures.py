"""Gestures from motion alone."""

import math
from collections.abc import Callable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.vision.head_gestures import Gesture, HeadGestures

Path = Callable[[float], float]
RATE = 10


def made(
    x: Path = lambda _t: 0.0,
    y: Path = lambda _t: 0.0,
    roll: Path = lambda _t: 0.0,
    seconds: float = 6.0,
    rate: float = RATE,
) -> list[tuple[Gesture, float]]:
    """The gestures that a head makes, whose place and lean are functions of time."""
    gestures, found = HeadGestures(), []
    for step in range(round(seconds * RATE)):
        now, before = step / RATE, max(0, step - 1) / RATE
        gesture = gestures.add_motion(now, x(now) - x(before), y(now) - y(before), roll(now) - roll(before))
        if gesture is not None:
            found.append((gesture, now))
    return found


def names(found: list[tuple[Gesture, float]]) -> list[Gesture]:
    return [gesture for gesture, _ in found]


def swings(reach: float, frequency: float, times: float, begin: float = 1.0) -> Path:
    def at(now: float) -> float:
        passed = min(max(now - begin, 0.0), times / frequency)
        return reach * (1 - math.cos(2 * math.pi * frequency * passed)) / 2

    return at


def drift(speed: float) -> Path:
    return lambda now: speed * now


@pytest.mark.parametrize("frequency", [0.8, 1.0, 1.5, 2.0, 3.0])
@pytest.mark.parametrize("reach", [0.1, 0.3, -0.3])
def test_a_nod_and_a_shake(frequency: float, reach: float) -> None:
    assert names(made(y=swings(reach, frequency, 3))) == ["nod"]
    assert names(made(x=swings(reach, frequency, 3))) == ["shake_head"]


def test_continuous_nodding_is_one_nod_and_another_after_a_rest() -> None:
    assert names(made(y=swings(0.2, 1.5, 6))) == ["nod"]
    twice = swings(0.2, 1.5, 3), swings(0.2, 1.5, 3, begin=5.0)
    assert names(made(y=lambda now: twice[0](now) + twice[1](now), seconds=8)) == ["nod", "nod"]


def test_nod_is_detected_while_the_head_moves_a_little_sideways() -> None:
    assert names(made(x=drift(0.02), y=swings(0.2, 1.5, 3))) == ["nod"]


@pytest.mark.parametrize(
    ("why", "x", "y"),
    [
        ("at rest", drift(0), drift(0)),
        ("walks by", drift(0.8), drift(0)),
        ("sits down", drift(0), swings(0.6, 1.0, 0.5)),
        ("looks down and up again", drift(0), swings(0.3, 1.0, 1)),
        ("trembles", swings(0.03, 2.0, 8), swings(0.03, 2.0, 8)),
        ("sways slowly", swings(0.4, 0.3, 2), drift(0)),
        ("jumps about", drift(0), swings(0.9, 1.0, 4)),
        ("moves aslant", swings(0.2, 1.5, 4), swings(0.2, 1.5, 4)),
    ],
)
def test_other_motion_is_no_gesture(why: str, x: Path, y: Path) -> None:
    assert made(x, y) == [], why


@pytest.mark.parametrize("degrees", [15, -25])
def test_a_tilt_that_is_held_and_told_once(degrees: float) -> None:
    def roll(now: float) -> float:
        return math.radians(degrees) * min(max(min(now - 1.0, 3.5 - now) / 0.3, 0.0), 1.0)

    ((gesture, at),) = made(roll=roll)
    assert gesture == "tilt"
    assert 1.3 < at < 2.0


@pytest.mark.parametrize(("degrees", "held"), [(8, 3.0), (25, 0.2)])
def test_small_or_short_tilt_is_no_gesture(degrees: float, held: float) -> None:
    assert made(roll=lambda now: math.radians(degrees) if 1.0 <= now < 1.0 + held else 0.0) == []


def test_two_tilts() -> None:
    assert names(made(roll=lambda now: 0.4 if 1 <= now < 2 or 3 <= now < 4 else 0.0)) == ["tilt", "tilt"]


@given(
    steps=st.lists(st.tuples(st.floats(0, 0.5), st.floats(-1, 1), st.floats(-1, 1), st.floats(-0.5, 0.5)), max_size=60)
)
def test_any_motion_is_read(steps: list[tuple[float, float, float, float]]) -> None:
    gestures, now = HeadGestures(), 0.0
    for passed, x, y, roll in steps:
        now += passed
        assert gestures.add_motion(now, x, y, roll) in ("nod", "tilt", "shake_head", None)
