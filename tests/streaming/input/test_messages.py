import json
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.input.messages import (
    MESSAGE_LIMIT,
    NOTHING,
    Change,
    Gamepad,
    Held,
    InputError,
    Pointer,
    State,
    Touch,
    read_change,
    read_state,
)

from tests.support.input import CHANGES, HELD, STAMP


@given(st.builds(State, **STAMP, held=HELD))
def test_a_state_is_read_as_it_was_written(state: State) -> None:
    assert read_state(json.dumps(state.to_json())) == state


@given(CHANGES)
def test_a_change_is_read_as_it_was_written(change: Change) -> None:
    assert read_change(json.dumps(change.to_json())) == change


def test_absent_members_are_not_held() -> None:
    assert read_state('{"seq": 0, "t": 0}') == State(0, 0.0, NOTHING)
    assert State(0, 0.0).to_json() == {"seq": 0, "t": 0.0, "event": "state"}


def test_the_largest_state_of_a_page_has_room() -> None:
    pad = Gamepad((-0.1234,) * 4, (0.1234,) * 17)
    touches = tuple(Touch(number, 0.1234, 0.1234) for number in range(10))
    held = Held(frozenset(f"Numpad{n:02}" for n in range(16)), Pointer(0.1234, 0.1234, 31), touches, pad)
    text = json.dumps(State(2**31, 123456789.1, held).to_json(), separators=(",", ":"))
    assert len(text) < MESSAGE_LIMIT


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"seq": -1}, "seq"),
        ({"seq": True}, "seq"),
        ({"seq": 1.5}, "seq"),
        ({"t": "now"}, "t"),
        ({"t": math.nan}, "t"),
        ({"keys": "KeyW"}, "keys"),
        ({"keys": ["W!"]}, "keys"),
        ({"keys": [5]}, "keys"),
        ({"keys": ["A"] * 17}, "keys"),
        ({"pointer": [0.5, 0.5]}, "pointer"),
        ({"pointer": [0.5, 1.5, 0]}, "y"),
        ({"pointer": [0.5, 0.5, 32]}, "buttons"),
        ({"touches": [[1, 0.5]]}, "touches"),
        ({"touches": [[1, 0, 0], [1, 1, 1]]}, "touches"),
        ({"gamepad": []}, "gamepad"),
        ({"gamepad": {"axes": [0] * 5}}, "axes"),
        ({"gamepad": {"axes": [-1.1]}}, "axes"),
        ({"gamepad": {"buttons": [math.inf]}}, "buttons"),
    ],
)
def test_a_wrong_state_is_refused_by_name(wrong: dict[str, Any], named: str) -> None:
    with pytest.raises(InputError, match=named):
        read_state(json.dumps({"seq": 1, "t": 1, **wrong}))


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({}, "event"),
        ({"event": ["key"]}, "event"),
        ({"event": "dance"}, "event"),
        ({"event": "key", "code": "KeyW", "down": 1}, "down"),
        ({"event": "button", "button": 5, "down": True, "x": 0, "y": 0}, "button"),
        ({"event": "wheel", "dx": 0, "dy": 1e6, "x": 0, "y": 0}, "dy"),
        ({"event": "touch", "down": True, "x": 0, "y": 0}, "id"),
        ({"event": "pad", "button": 17, "down": True}, "button"),
        ({"event": "release", "why": "tired"}, "why"),
    ],
)
def test_a_wrong_change_is_refused_by_name(wrong: dict[str, Any], named: str) -> None:
    with pytest.raises(InputError, match=named):
        read_change(json.dumps({"seq": 1, "t": 1, **wrong}))


@pytest.mark.parametrize("text", ["", "{", "[]", "null", "[" * 1000, '{"seq": 1e999}', '{"a":' * 200, "9" * 900])
def test_invalid_message_is_refused(text: str) -> None:
    for read in (read_state, read_change):
        with pytest.raises(InputError):
            read(text)


NAMES = st.sampled_from(
    ["seq", "t", "keys", "pointer", "touches", "gamepad", "event", "code", "down", "x", "why", "id"]
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(NAMES, inner, max_size=6),
    max_leaves=20,
)


@given(st.text() | st.dictionaries(NAMES, JSON).map(json.dumps))
def test_whatever_comes_is_a_message_or_an_error_with_a_name(text: str) -> None:
    for read in (read_state, read_change):
        try:
            message = read(text)
        except InputError:
            continue
        assert read(json.dumps(message.to_json())) == message


@pytest.mark.parametrize(
    ("held", "active"),
    [
        (NOTHING, False),
        (Held(pointer=Pointer(0.5, 0.5)), False),
        (Held(gamepad=Gamepad((0.05, -0.05), (0.0,))), False),
        (Held(frozenset({"KeyW"})), True),
        (Held(pointer=Pointer(0.5, 0.5, 1)), True),
        (Held(touches=(Touch(1, 0.5, 0.5),)), True),
        (Held(gamepad=Gamepad((0.0, -0.06))), True),
        (Held(gamepad=Gamepad((), (0.0, 1.0))), True),
    ],
)
def test_whether_a_hand_is_on_it(held: Held, active: bool) -> None:
    assert held.is_active == active
