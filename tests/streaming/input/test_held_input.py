from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.input.held_input import HeldInput, changed
from openrois_streaming.input.messages import (
    NOTHING,
    Button,
    Change,
    Gamepad,
    Held,
    Key,
    Message,
    Pad,
    Pointer,
    Release,
    State,
    Touch,
    TouchPoint,
    Wheel,
)

from tests.support.input import CHANGES, HELD

W, A = Held(frozenset({"KeyW"})), Held(frozenset({"KeyA"}))


def key(seq: int, code: str = "KeyW", *, down: bool = True) -> Key:
    return Key(seq, 0.0, code, down)


def state(seq: int, held: Held = NOTHING) -> State:
    return State(seq, 0.0, held)


@pytest.mark.parametrize(
    ("told", "taken", "held"),
    [
        ([key(1)], [True], W),
        ([key(1), key(2, down=False)], [True, True], NOTHING),
        ([key(1, down=False)], [True], NOTHING),
        ([state(1, W), state(3, A), state(2, W)], [True, True, False], A),
        ([state(1, W), state(1, A)], [True, False], W),
        ([key(1), key(1, "KeyA")], [True, False], W),
        # The state of number 2 knows of the change before it, which comes later and happened all the same.
        ([state(2), key(1), key(3, "KeyA")], [True, True, True], A),
        ([key(2), state(1, A)], [True, False], W),
        ([state(1, W), Release(2, 0.0, "blur"), state(1, W)], [True, True, False], NOTHING),
    ],
)
def test_the_newest_counts(told: list[Message], taken: list[bool], held: Held) -> None:
    follower = HeldInput()
    assert [follower.apply(message) for message in told] == taken
    assert follower.held == held


def test_clear_releases_all_input() -> None:
    follower = HeldInput()
    follower.apply(state(5, W))
    follower.clear()
    assert follower.held == NOTHING
    assert not follower.apply(state(4, W))
    assert follower.apply(state(6, W))


def test_the_pointer() -> None:
    held = changed(NOTHING, Button(1, 0.0, 2, True, 0.1, 0.2))
    assert held.pointer == Pointer(0.1, 0.2, 2)
    held = changed(held, Button(2, 0.0, 0, True, 0.3, 0.4))
    held = changed(held, Wheel(3, 0.0, 0, 5, 0.5, 0.6))
    assert held.pointer == Pointer(0.5, 0.6, 3)
    assert changed(held, Button(4, 0.0, 2, False, 0.5, 0.6)).pointer == Pointer(0.5, 0.6, 1)
    assert changed(NOTHING, Wheel(1, 0.0, 1, 1, 0.5, 0.5)).pointer == Pointer(0.5, 0.5, 0)


def test_fingers() -> None:
    one, two = Touch(1, 0.1, 0.1), Touch(2, 0.2, 0.2)
    held = changed(changed(NOTHING, TouchPoint(1, 0.0, True, one)), TouchPoint(2, 0.0, True, two))
    assert held.touches == (one, two)
    moved = changed(held, TouchPoint(3, 0.0, True, replace(one, x=0.9)))
    assert [touch.x for touch in moved.touches] == [0.2, 0.9]
    assert changed(held, TouchPoint(4, 0.0, False, one)).touches == (two,)


def test_the_gamepad() -> None:
    held = changed(NOTHING, Pad(1, 0.0, 16, True))
    assert held.gamepad is not None
    assert (held.gamepad.button(16), held.gamepad.button(0), held.gamepad.axis(3)) == (1.0, 0.0, 0.0)
    stick = Held(gamepad=Gamepad((0.5, -0.5), (1.0,)))
    pressed = changed(stick, Pad(2, 0.0, 0, False)).gamepad
    assert pressed is not None
    assert (pressed.axis(0), pressed.button(0), len(pressed.buttons)) == (0.5, 0.0, 17)


def test_more_than_a_message_can_tell_is_passed_over() -> None:
    full = Held(frozenset(f"F{n}" for n in range(16)), None, tuple(Touch(n, 0, 0) for n in range(10)))
    assert changed(full, key(1)) == full
    assert changed(full, TouchPoint(1, 0.0, True, Touch(99, 0, 0))) == full
    assert changed(full, key(1, "F3", down=False)).keys == full.keys - {"F3"}


@given(HELD, st.lists(CHANGES))
def test_held_input_always_fits_a_message(held: Held, changes: list[Change]) -> None:
    for change in changes:
        held = changed(held, change)
    assert len(held.keys) <= 16
    assert len(held.touches) <= 10
    assert changed(held, Release(0, 0.0, "bye")) == NOTHING
