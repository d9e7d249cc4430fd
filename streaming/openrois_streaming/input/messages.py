"""Input messages of an application: the state of all that is held, and each change of it. Pure.

Names and numbers are the W3C's: keys are `KeyboardEvent.code`, the buttons of a pointer `MouseEvent.button` and
`.buttons`, gamepads have the standard mapping (17 buttons from 0 to 1, four axes from -1 to 1, up and left negative).
Places in the picture go from 0, 0 (top left) to 1, 1. Every message has `seq`, one counter for all of them, and `t`,
the application's own clock in ms.
"""

import json
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Literal, TypeAlias, get_args

__all__ = [
    "MESSAGE_LIMIT",
    "NOTHING",
    "Button",
    "Change",
    "Gamepad",
    "Held",
    "InputError",
    "Key",
    "Message",
    "Pad",
    "Pointer",
    "Release",
    "State",
    "Touch",
    "TouchPoint",
    "Wheel",
    "read_change",
    "read_state",
]

MESSAGE_LIMIT: Final = 1024
"""Bytes of a message, in UTF-8."""
MAX_KEYS: Final = 16
MAX_TOUCHES: Final = 10
MAX_BUTTONS: Final = 17
MAX_AXES: Final = 4
_SAFE: Final = 2**53 - 1
_FAR: Final = 100_000.0
_MOUSE_BUTTONS: Final = 5
_CODE: Final = re.compile(r"[A-Za-z0-9]{1,32}")

_AT_REST: Final = 0.05
"""Deflection of an untouched stick, and pressure of an untouched button, that count as none."""

Why: TypeAlias = Literal["blur", "hidden", "bye", "lost"]
"""Why all input is released: the page lost the focus, is hidden, stops operating, or is gone."""


@dataclass(frozen=True, slots=True)
class Pointer:
    """Position of a mouse or pen, and the bits of the buttons that are down (`MouseEvent.buttons`)."""

    x: float
    y: float
    buttons: int = 0

    def to_json(self) -> list[float]:
        """Return its form in a message."""
        return [self.x, self.y, self.buttons]


@dataclass(frozen=True, slots=True)
class Touch:
    """Finger on the picture; `id` stays until it is lifted."""

    id: int
    x: float
    y: float

    def to_json(self) -> list[float]:
        """Return its form in a message."""
        return [self.id, self.x, self.y]


@dataclass(frozen=True, slots=True)
class Gamepad:
    """Gamepad in the standard mapping; missing axes and buttons are left out at the end."""

    axes: tuple[float, ...] = ()
    buttons: tuple[float, ...] = ()

    def axis(self, index: int) -> float:
        """Return an axis; 0 if the gamepad has no such axis."""
        return self.axes[index] if index < len(self.axes) else 0.0

    def button(self, index: int) -> float:
        """Return a button from 0 (up) to 1 (down); 0 if the gamepad has no such button."""
        return self.buttons[index] if index < len(self.buttons) else 0.0

    @property
    def is_active(self) -> bool:
        """Whether a stick is deflected or a button pressed."""
        return any(abs(each) > _AT_REST for each in (*self.axes, *self.buttons))

    def to_json(self) -> dict[str, Any]:
        """Return its form in a message."""
        return {"axes": list(self.axes), "buttons": list(self.buttons)}


@dataclass(frozen=True, slots=True)
class Held:
    """Input held at one moment."""

    keys: frozenset[str] = frozenset()
    pointer: Pointer | None = None
    touches: tuple[Touch, ...] = ()
    gamepad: Gamepad | None = None

    @property
    def is_active(self) -> bool:
        """Whether anything is pressed, touched or deflected: while it is, states keep coming."""
        pressed = self.pointer is not None and self.pointer.buttons != 0
        return bool(self.keys or self.touches or pressed or (self.gamepad is not None and self.gamepad.is_active))

    def to_json(self) -> dict[str, Any]:
        """Return the members of a message; absent devices are left out."""
        members: dict[str, Any] = {}
        if self.keys:
            members["keys"] = sorted(self.keys)
        if self.pointer is not None:
            members["pointer"] = self.pointer.to_json()
        if self.touches:
            members["touches"] = [touch.to_json() for touch in self.touches]
        if self.gamepad is not None:
            members["gamepad"] = self.gamepad.to_json()
        return members


NOTHING: Final = Held()
"""No input."""


@dataclass(frozen=True, slots=True)
class State:
    """State of all input. It replaces every state before."""

    seq: int
    t: float
    held: Held = field(default=NOTHING)

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"seq": self.seq, "t": self.t, "event": "state", **self.held.to_json()}


@dataclass(frozen=True, slots=True)
class Key:
    """Key that went down or up."""

    seq: int
    t: float
    code: str
    down: bool

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"seq": self.seq, "t": self.t, "event": "key", "code": self.code, "down": self.down}


@dataclass(frozen=True, slots=True)
class Button:
    """Button of the pointer (`MouseEvent.button`, 0 to 4) that went down or up at a position."""

    seq: int
    t: float
    button: int
    down: bool
    x: float
    y: float

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        members = {"button": self.button, "down": self.down, "x": self.x, "y": self.y}
        return {"seq": self.seq, "t": self.t, "event": "button", **members}


@dataclass(frozen=True, slots=True)
class Wheel:
    """Turn of a wheel in CSS pixels, right and down positive, at a position."""

    seq: int
    t: float
    dx: float
    dy: float
    x: float
    y: float

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        members = {"dx": self.dx, "dy": self.dy, "x": self.x, "y": self.y}
        return {"seq": self.seq, "t": self.t, "event": "wheel", **members}


@dataclass(frozen=True, slots=True)
class TouchPoint:
    """Finger that was set down or lifted."""

    seq: int
    t: float
    down: bool
    touch: Touch

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        members = {"down": self.down, "id": self.touch.id, "x": self.touch.x, "y": self.touch.y}
        return {"seq": self.seq, "t": self.t, "event": "touch", **members}


@dataclass(frozen=True, slots=True)
class Pad:
    """Button of the gamepad (0 to 16) that went down or up."""

    seq: int
    t: float
    button: int
    down: bool

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"seq": self.seq, "t": self.t, "event": "pad", "button": self.button, "down": self.down}


@dataclass(frozen=True, slots=True)
class Release:
    """Release of all input until the next message."""

    seq: int
    t: float
    why: Why

    def to_json(self) -> dict[str, Any]:
        """Return the whole message."""
        return {"seq": self.seq, "t": self.t, "event": "release", "why": self.why}


Change: TypeAlias = Key | Button | Wheel | TouchPoint | Pad | Release
Message: TypeAlias = State | Change


def read_state(text: str) -> State:
    """Read a message of the channel `input`.

    Raises:
        InputError: it is not a valid message; the text names the wrong member.
    """
    body = _object(text)
    keys = frozenset(_code(key, "keys") for key in _array(body.get("keys", []), "keys", MAX_KEYS))
    touches = tuple(_touch(item) for item in _array(body.get("touches", []), "touches", MAX_TOUCHES))
    if len({touch.id for touch in touches}) < len(touches):
        raise InputError("touches: two touches have the same id; each needs its own")
    held = Held(keys, _pointer(body.get("pointer")), touches, _gamepad(body.get("gamepad")))
    return State(*_stamp(body), held)


def read_change(text: str) -> Change:
    """Read a message of the channel `control`.

    Raises:
        InputError: it is not a valid message; the text names the wrong member.
    """
    body = _object(text)
    event = body.get("event")
    read = _CHANGES.get(event) if isinstance(event, str) else None
    if read is None:
        raise InputError(f"event: must be one of {', '.join(_CHANGES)}")
    return read(body)


def _object(text: str) -> Mapping[str, Any]:
    try:
        body = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError("the message is not JSON: send one JSON object") from error
    if not isinstance(body, dict):
        raise InputError("the message is not a JSON object")
    return body


def _stamp(body: Mapping[str, Any]) -> tuple[int, float]:
    return _integer(body.get("seq"), "seq", 0, _SAFE), _number(body.get("t"), "t", 0, _SAFE)


def _code(value: Any, name: str) -> str:
    if not isinstance(value, str) or _CODE.fullmatch(value) is None:
        raise InputError(f"{name}: must be the code of a key (KeyboardEvent.code)")
    return value


def _place(x: Any, y: Any) -> tuple[float, float]:
    return _number(x, "x", 0, 1), _number(y, "y", 0, 1)


def _pointer(value: Any) -> Pointer | None:
    if value is None:
        return None
    if len(_array(value, "pointer", 3)) != 3:
        raise InputError("pointer: must be an array of x, y and buttons")
    x, y, buttons = value
    return Pointer(*_place(x, y), _integer(buttons, "pointer buttons", 0, 2**_MOUSE_BUTTONS - 1))


def _touch(value: Any) -> Touch:
    if len(_array(value, "touches", 3)) != 3:
        raise InputError("touches: each must be an array of id, x and y")
    identifier, x, y = value
    return Touch(_integer(identifier, "touches id", 0, _SAFE), *_place(x, y))


def _gamepad(value: Any) -> Gamepad | None:
    if value is None:
        return None
    if not isinstance(value, dict):
        raise InputError("gamepad: must be an object")
    axes = _array(value.get("axes", []), "axes", MAX_AXES)
    buttons = _array(value.get("buttons", []), "buttons", MAX_BUTTONS)
    return Gamepad(
        tuple(_number(each, "axes", -1, 1) for each in axes), tuple(_number(each, "buttons", 0, 1) for each in buttons)
    )


def _key(body: Mapping[str, Any]) -> Key:
    return Key(*_stamp(body), _code(body.get("code"), "code"), _truth(body, "down"))


def _button(body: Mapping[str, Any]) -> Button:
    button = _integer(body.get("button"), "button", 0, _MOUSE_BUTTONS - 1)
    return Button(*_stamp(body), button, _truth(body, "down"), *_place(body.get("x"), body.get("y")))


def _wheel(body: Mapping[str, Any]) -> Wheel:
    turned = _number(body.get("dx"), "dx", -_FAR, _FAR), _number(body.get("dy"), "dy", -_FAR, _FAR)
    return Wheel(*_stamp(body), *turned, *_place(body.get("x"), body.get("y")))


def _touch_point(body: Mapping[str, Any]) -> TouchPoint:
    touch = _touch([body.get("id"), body.get("x"), body.get("y")])
    return TouchPoint(*_stamp(body), _truth(body, "down"), touch)


def _pad(body: Mapping[str, Any]) -> Pad:
    return Pad(*_stamp(body), _integer(body.get("button"), "button", 0, MAX_BUTTONS - 1), _truth(body, "down"))


def _release(body: Mapping[str, Any]) -> Release:
    why = next((each for each in get_args(Why) if each == body.get("why")), None)
    if why is None:
        raise InputError(f"why: must be one of {', '.join(get_args(Why))}")
    return Release(*_stamp(body), why)


_CHANGES: Final[Mapping[str, Callable[[Mapping[str, Any]], Change]]] = {
    "key": _key,
    "button": _button,
    "wheel": _wheel,
    "touch": _touch_point,
    "pad": _pad,
    "release": _release,
}


class InputError(ValueError):
    """Input message that is invalid. The text names the wrong member."""


def _number(value: Any, name: str, low: float, high: float) -> float:
    """Read a number from `low` to `high`; NaN is refused."""
    if not isinstance(value, int | float) or isinstance(value, bool) or not low <= value <= high:
        raise InputError(f"{name}: must be a number from {low:g} to {high:g}")
    return float(value)


def _integer(value: Any, name: str, low: int, high: int) -> int:
    """Read an integer from `low` to `high`."""
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise InputError(f"{name}: must be an integer from {low} to {high}")
    return value


def _truth(body: Mapping[str, Any], name: str) -> bool:
    """Read true or false."""
    value = body.get(name)
    if not isinstance(value, bool):
        raise InputError(f"{name}: must be true or false")
    return value


def _array(value: Any, name: str, limit: int) -> list[Any]:
    """Read an array of at most `limit` items."""
    if not isinstance(value, list) or len(value) > limit:
        raise InputError(f"{name}: must be an array of at most {limit} items")
    return value
