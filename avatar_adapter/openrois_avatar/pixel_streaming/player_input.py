"""The input of a player, converted into messages of `openrois_streaming.input`. Pure."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final, TypeAlias

from openrois_streaming.input.held_input import changed
from openrois_streaming.input.messages import (
    MAX_BUTTONS,
    MAX_TOUCHES,
    NOTHING,
    Button,
    Change,
    Gamepad,
    Key,
    Pad,
    Pointer,
    State,
    Touch,
    TouchPoint,
    Wheel,
)
from openrois_streaming.input.messages import Message as InputMessage

from openrois_avatar.pixel_streaming.keys import CODES
from openrois_avatar.pixel_streaming.protocol import Message

__all__ = ["PADS_LIMIT", "PlayerInput"]

PADS_LIMIT: Final = 4
"""Gamepads of one player that get a number; the first one counts."""

_MOUSE_BUTTONS: Final = 5
_STICKS: Final = {1: (0, 1.0), 2: (1, -1.0), 3: (2, 1.0), 4: (3, -1.0)}
"""The axes of the W3C's standard gamepad, of which the vertical ones come with up positive."""
_TRIGGERS: Final = {5: 6, 6: 7}
"""The buttons of the W3C's standard gamepad that come as axes."""
_PIXELS: Final = -100 / 120
"""CSS pixels down for each unit of the wheel; a notch away from the user has 120."""

Taken: TypeAlias = tuple[InputMessage, ...]


class PlayerInput:
    """The input of one player. `held` has all keys, buttons, touches and axes that are held now.

    Args:
        clock: seconds, monotonic.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.held = NOTHING
        self._clock = clock
        self._since = clock()
        self._seq = 0
        self._pads: list[int] = []
        self._readers: Mapping[str, Callable[..., Taken]] = {
            "KeyDown": self._key_down,
            "KeyUp": self._key_up,
            "MouseLeave": self._mouse_left,
            "MouseDown": lambda button, x, y: self._mouse(button, x, y, down=True),
            "MouseUp": lambda button, x, y: self._mouse(button, x, y, down=False),
            "MouseMove": self._mouse_moved,
            "MouseWheel": self._wheel,
            "TouchStart": lambda _count, *fingers: self._touched(fingers, down=True),
            "TouchEnd": lambda _count, *fingers: self._touched(fingers, down=False),
            "TouchMove": self._touches_moved,
            "GamepadButtonPressed": lambda pad, button, _repeats: self._pad(pad, button, down=True),
            "GamepadButtonReleased": lambda pad, button, _repeats: self._pad(pad, button, down=False),
            "GamepadAnalog": self._analog,
            "GamepadDisconnected": self._pad_gone,
        }

    def read_changes(self, message: Message) -> Taken:
        """Return the changes of a message; none for a message without input, or with unsupported input."""
        reader = self._readers.get(message.name)
        return () if reader is None else reader(*message.values)

    def state(self) -> State:
        """Return the whole present state as a message."""
        return State(*self._stamp(), self.held)

    def let_go(self) -> None:
        """Release all that is held, until it is pressed or moved again."""
        self.held = NOTHING

    def add_pad(self) -> int | None:
        """Add a gamepad and return its number; None if there are too many."""
        number = next((each for each in range(PADS_LIMIT) if each not in self._pads), None)
        if number is not None:
            self._pads.append(number)
        return number

    def _stamp(self) -> tuple[int, float]:
        self._seq += 1
        return self._seq, round((self._clock() - self._since) * 1000, 1)

    def _change(self, change: Change) -> Taken:
        self.held = changed(self.held, change)
        return (change,)

    def _key_down(self, key: int, repeats: int) -> Taken:
        code = CODES.get(key)
        if code is None:
            return ()
        # A repeating key is held, which is a change where it was released meanwhile, and always a sign of life.
        return (self.state(),) if repeats and code in self.held.keys else self._change(Key(*self._stamp(), code, True))

    def _key_up(self, key: int) -> Taken:
        code = CODES.get(key)
        return () if code is None else self._change(Key(*self._stamp(), code, False))

    def _mouse(self, button: int, x: int, y: int, *, down: bool) -> Taken:
        if button >= _MOUSE_BUTTONS:
            return ()
        return self._change(Button(*self._stamp(), button, down, _share(x), _share(y)))

    def _mouse_moved(self, x: int, y: int, _dx: int, _dy: int) -> Taken:
        buttons = 0 if self.held.pointer is None else self.held.pointer.buttons
        self.held = replace(self.held, pointer=Pointer(_share(x), _share(y), buttons))
        return (self.state(),)

    def _mouse_left(self) -> Taken:
        self.held = replace(self.held, pointer=None)
        return (self.state(),)

    def _wheel(self, delta: int, x: int, y: int) -> Taken:
        return self._change(Wheel(*self._stamp(), 0.0, delta * _PIXELS, _share(x), _share(y)))

    def _touched(self, fingers: tuple[int, ...], *, down: bool) -> Taken:
        touches = _touches(fingers)
        return tuple(each for touch in touches for each in self._change(TouchPoint(*self._stamp(), down, touch)))

    def _touches_moved(self, _count: int, *fingers: int) -> Taken:
        moved = {touch.id: touch for touch in _touches(fingers)}
        self.held = replace(self.held, touches=tuple(moved.get(each.id, each) for each in self.held.touches))
        return (self.state(),)

    def _counts(self, pad: int) -> bool:
        """Return whether a gamepad is the first one; without an announced one any is."""
        return not self._pads or pad == self._pads[0]

    def _pad(self, pad: int, button: int, *, down: bool) -> Taken:
        if not self._counts(pad) or button >= MAX_BUTTONS:
            return ()
        return self._change(Pad(*self._stamp(), button, down))

    def _analog(self, pad: int, axis: int, value: float) -> Taken:
        if not self._counts(pad) or not math.isfinite(value):
            return ()
        gamepad = self.held.gamepad or Gamepad()
        if axis in _STICKS:
            index, sign = _STICKS[axis]
            axes = [gamepad.axis(each) for each in range(len(_STICKS))]
            axes[index] = min(1.0, max(-1.0, sign * value)) + 0.0
            gamepad = replace(gamepad, axes=tuple(axes))
        elif axis in _TRIGGERS:
            buttons = [gamepad.button(each) for each in range(MAX_BUTTONS)]
            buttons[_TRIGGERS[axis]] = min(1.0, max(0.0, value))
            gamepad = replace(gamepad, buttons=tuple(buttons))
        else:
            return ()
        self.held = replace(self.held, gamepad=gamepad)
        return (self.state(),)

    def _pad_gone(self, pad: int) -> Taken:
        counted = self._counts(pad)
        self._pads = [each for each in self._pads if each != pad]
        if not counted:
            return ()
        self.held = replace(self.held, gamepad=None)
        return (self.state(),)


def _share(place: int) -> float:
    """Return a coordinate from 0 to 65535 as a share of the picture."""
    return place / 65535


def _touches(fingers: tuple[int, ...]) -> tuple[Touch, ...]:
    """Return the touches on the picture, of five numbers each: x, y, id, force, and whether it is valid."""
    groups = [fingers[start : start + 5] for start in range(0, len(fingers), 5)]
    return tuple(Touch(which, _share(x), _share(y)) for x, y, which, _force, valid in groups if valid)[:MAX_TOUCHES]
