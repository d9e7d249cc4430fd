"""What a player holds, from the messages of Epic's front-end."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_avatar.pixel_streaming.keys import CODES
from openrois_avatar.pixel_streaming.player_input import PADS_LIMIT, PlayerInput
from openrois_avatar.pixel_streaming.protocol import TO_STREAMER, Message
from openrois_streaming.input.messages import (
    NOTHING,
    Button,
    Key,
    Pad,
    State,
    TouchPoint,
    Wheel,
    read_change,
    read_state,
)


class Player(PlayerInput):
    def __init__(self) -> None:
        self.now = 5.0
        super().__init__(lambda: self.now)

    def does(self, name: str, *values: float) -> list[object]:
        return list(self.read_changes(Message(name, values)))


@pytest.fixture
def player() -> Player:
    return Player()


def test_keys_have_the_names_of_today(player: Player) -> None:
    player.now = 5.25
    assert player.does("KeyDown", 87, 0) == [Key(1, 250.0, "KeyW", True)]
    player.does("KeyDown", 38, 0)
    assert player.held.keys == {"KeyW", "ArrowUp"}
    assert player.does("KeyUp", 87) == [Key(3, 250.0, "KeyW", False)]
    assert player.held.keys == {"ArrowUp"}
    assert player.does("KeyDown", 7, 0) == player.does("KeyUp", 7) == []
    assert {CODES[number] for number in (48, 90, 105, 123, 255)} == {"Digit0", "KeyZ", "Numpad9", "F12", "AltRight"}


def test_a_key_that_repeats_is_a_sign_of_life_and_pressed_again_where_it_was_let_go(player: Player) -> None:
    player.does("KeyDown", 87, 0)
    (repeated,) = player.does("KeyDown", 87, 1)
    assert isinstance(repeated, State)
    assert repeated.held.keys == {"KeyW"}
    player.let_go()
    assert player.held == NOTHING
    assert player.does("KeyDown", 87, 1) == [Key(3, 0.0, "KeyW", True)]


def test_the_mouse_points_presses_and_turns_its_wheel(player: Player) -> None:
    assert player.does("MouseDown", 2, 65535, 0) == [Button(1, 0.0, 2, True, 1.0, 0.0)]
    (moved,) = player.does("MouseMove", 0, 65535, 3, 4)
    assert isinstance(moved, State)
    assert moved.held.pointer is not None
    assert (moved.held.pointer.x, moved.held.pointer.y, moved.held.pointer.buttons) == (0.0, 1.0, 2)
    assert player.does("MouseWheel", 120, 0, 0) == [Wheel(3, 0.0, 0.0, -100.0, 0.0, 0.0)]
    player.does("MouseUp", 2, 0, 0)
    player.does("MouseLeave")
    assert player.held.pointer is None
    player.does("MouseMove", 0, 0, 0, 0)
    assert player.held.pointer is not None
    assert player.does("MouseDown", 5, 0, 0) == player.does("MouseEnter") == player.does("KeyPress", 119) == []


def test_fingers_come_move_and_go(player: Player) -> None:
    came = player.does("TouchStart", 2, 0, 0, 0, 255, 1, 65535, 65535, 1, 255, 1)
    assert [isinstance(each, TouchPoint) and each.down for each in came] == [True, True]
    player.does("TouchMove", 1, 65535, 0, 0, 255, 1)
    assert [(each.id, each.x, each.y) for each in player.held.touches] == [(0, 1.0, 0.0), (1, 1.0, 1.0)]
    player.does("TouchEnd", 1, 0, 0, 1, 0, 1)
    assert [each.id for each in player.held.touches] == [0]
    assert player.does("TouchStart", 1, 65535, 65535, 2, 255, 0) == []


def test_sticks_have_up_negative_and_triggers_are_buttons(player: Player) -> None:
    assert player.add_pad() == 0
    for axis, value in ((1, 0.5), (2, 1.0), (3, -2.0), (4, -0.25), (5, 0.75), (6, 2.0)):
        player.does("GamepadAnalog", 0, axis, value)
    assert player.held.gamepad is not None
    assert player.held.gamepad.axes == (0.5, -1.0, -1.0, 0.25)
    assert (player.held.gamepad.button(6), player.held.gamepad.button(7)) == (0.75, 1.0)
    assert player.does("GamepadButtonPressed", 0, 12, 0) == [Pad(7, 0.0, 12, True)]
    player.does("GamepadButtonReleased", 0, 12, 0)
    assert player.held.gamepad.button(12) == 0.0
    assert player.does("GamepadAnalog", 0, 1, math.nan) == player.does("GamepadAnalog", 0, 7, 1.0) == []
    assert player.does("GamepadButtonPressed", 0, 17, 0) == []


def test_the_first_gamepad_counts_and_when_it_is_gone_the_next(player: Player) -> None:
    assert [player.add_pad() for _ in range(PADS_LIMIT + 1)] == [0, 1, 2, 3, None]
    assert player.does("GamepadAnalog", 1, 1, 1.0) == player.does("GamepadDisconnected", 1) == []
    player.does("GamepadAnalog", 0, 1, 1.0)
    player.does("GamepadDisconnected", 0)
    assert player.held.gamepad is None
    assert len(player.does("GamepadAnalog", 2, 1, 1.0)) == 1
    assert player.add_pad() == 0


def test_unannounced_gamepad_counts_without_an_announced_one(player: Player) -> None:
    assert len(player.does("GamepadAnalog", 0, 1, 1.0)) == 1


NUMBERS = {"uint8": (0, 255), "uint16": (0, 65535), "int16": (-32768, 32767)}
MESSAGES = st.sampled_from([name for name, layout in TO_STREAMER.items() if "string" not in layout.structure]).flatmap(
    lambda name: st.tuples(
        *(st.floats() if field == "double" else st.integers(*NUMBERS[field]) for field in TO_STREAMER[name].structure)
    ).map(lambda values: Message(name, values))
)


@given(st.lists(MESSAGES, max_size=40))
def test_whatever_is_done_is_what_an_application_could_say(messages: list[Message]) -> None:
    player = Player()
    for message in messages:
        for taken in player.read_changes(message):
            said = taken.to_json()
            assert (read_state if isinstance(taken, State) else read_change)(json.dumps(said)) is not None
