"""The input messages of an application: all that is held now, and each change of it. Pure.

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

from openrois_streaming.input.reading import InputError, array, integer, number, truth

__all__ = [
    "MESSAGE_LIMIT",
    "NOTHING",
    "Button",
    "Change",
    "Gamepad",
    "Held",
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
"""How far from the middle a stick may stand that nobody touches, and a button be down that nobody presses."""

Why: TypeAlias = Literal["blur", "hidden", "bye", "lost"]
"""Why all is let go: the page lost the focus, is not seen any more, does not want to operate any more, or is gone."""


@dataclass(frozen=True, slots=True)
class Pointer:
    """Where a mouse or pen points to, and the bits of the buttons that are down (`MouseEvent.buttons`)."""

    x: float
    y: float
    buttons: int = 0

    def to_json(self) -> list[float]:
        """As it stands in a message."""
        return [self.x, self.y, self.buttons]


@dataclass(frozen=True, slots=True)
class Touch:
    """A finger on the picture; `id` stays until it is lifted."""

    id: int
    x: float
    y: float

    def to_json(self) -> list[float]:
        """As it stands in a message."""
        return [self.id, self.x, self.y]


@dataclass(frozen=True, slots=True)
class Gamepad:
    """A gamepad in the standard mapping; what it does not have is missing at the end."""

    axes: tuple[float, ...] = ()
    buttons: tuple[float, ...] = ()

    def axis(self, index: int) -> float:
        """An axis, or 0 if it has no such one."""
        return self.axes[index] if index < len(self.axes) else 0.0

    def button(self, index: int) -> float:
        """A button from 0 (up) to 1 (down), or 0 if it has no such one."""
        return self.buttons[index] if index < len(self.buttons) else 0.0

    @property
    def is_active(self) -> bool:
        """Whether somebody has a hand on it."""
        return any(abs(each) > _AT_REST for each in (*self.axes, *self.buttons))

    def to_json(self) -> dict[str, Any]:
        """As it stands in a message."""
        return {"axes": list(self.axes), "buttons": list(self.buttons)}


@dataclass(frozen=True, slots=True)
class Held:
    """All that is held at one moment."""

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
        """The members of a message; what is not there is left out."""
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
"""Nothing is held, and nothing points anywhere."""


@dataclass(frozen=True, slots=True)
class State:
    """All that is held now. It takes the place of every one before."""

    seq: int
    t: float
    held: Held = field(default=NOTHING)

    def to_json(self) -> dict[str, Any]:
        """The whole message."""
        return {"seq": self.seq, "t": self.t, "event": "state", **self.held.to_json()}


@dataclass(frozen=True, slots=True)
class Key:
    """A key went down or up."""

    seq: int
    t: float
    code: str
    down: bool

    def to_json(self) -> dict[str, Any]:
        """The whole message."""
        return {"seq": self.seq, "t": self.t, "event": "key", "code": self.code, "down": self.down}


@dataclass(frozen=True, slots=True)
class Button:
    """A button of the pointer (`MouseEvent.button`, 0 to 4) went down or up at a place."""

    seq: int
    t: float
    button: int
    down: bool
    x: float
    y: float

    def to_json(self) -> dict[str, Any]:
        """The whole message."""
        members = {"button": self.button, "down": self.down, "x": self.x, "y": self.y}
        return {"seq": self.seq, "t": self.t, "event": "button", **members}


@dataclass(frozen=True, slots=True)
class Wheel:
    """A wheel was turned by so many CSS pixels, right and down positive, at a place."""

    seq: int
    t: float
    dx: float
    dy: float
    x: float
    y: float

    def to_json(self) -> dict[str, Any]:
        """The whole message."""
        members = {"dx": self.dx, "dy": self.dy, "x": self.x, "y": self.y}
        return {"seq": self.seq, "t": self.t, "event": "wheel", **members}


@dataclass(frozen=True, slots=True)
class TouchPoint:
    """A finger was set down or lifted."""

    seq: int
    t: float
    down: bool
    touch: Touch

    def to_json(self) -> dict[str, Any]:
        """The whole message."""
        members = {"down": self.down, "id": self.touch.id, "x": self.touch.x, "y": self.touch.y}
        return {"seq": self.seq, "t": self.t, "event": "touch", **members}


@dataclass(frozen=True, slots=True)
class Pad:
    """A button of the gamepad (0 to 16) went down or up."""

    seq: int
    t: float
    button: int
    down: bool

    def to_json(self) -> dict[str, Any]:
        """The whole message."""
        return {"seq": self.seq, "t": self.t, "event": "pad", "button": self.button, "down": self.down}


@dataclass(frozen=True, slots=True)
class Release:
    """All is let go, and nothing more is done until the next message."""

    seq: int
    t: float
    why: Why

    def to_json(self) -> dict[str, Any]:
        """The whole message."""
        return {"seq": self.seq, "t": self.t, "event": "release", "why": self.why}


Change: TypeAlias = Key | Button | Wheel | TouchPoint | Pad | Release
Message: TypeAlias = State | Change


def read_state(text: str) -> State:
    """Read a message of the channel `input`.

    Raises:
        InputError: it is none; the text names what is wrong.
    """
    body = _object(text)
    keys = frozenset(_code(key, "keys") for key in array(body.get("keys", []), "keys", MAX_KEYS))
    touches = tuple(_touch(item) for item in array(body.get("touches", []), "touches", MAX_TOUCHES))
    if len({touch.id for touch in touches}) < len(touches):
        raise InputError("touches: two with one id")
    held = Held(keys, _pointer(body.get("pointer")), touches, _gamepad(body.get("gamepad")))
    return State(*_stamp(body), held)


def read_change(text: str) -> Change:
    """Read a message of the channel `control`.

    Raises:
        InputError: it is none; the text names what is wrong.
    """
    body = _object(text)
    event = body.get("event")
    read = _CHANGES.get(event) if isinstance(event, str) else None
    if read is None:
        raise InputError(f"event: expected one of {', '.join(_CHANGES)}")
    return read(body)


def _object(text: str) -> Mapping[str, Any]:
    try:
        body = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError("the message is not JSON") from error
    if not isinstance(body, dict):
        raise InputError("the message is not an object")
    return body


def _stamp(body: Mapping[str, Any]) -> tuple[int, float]:
    return integer(body.get("seq"), "seq", 0, _SAFE), number(body.get("t"), "t", 0, _SAFE)


def _code(value: Any, name: str) -> str:
    if not isinstance(value, str) or _CODE.fullmatch(value) is None:
        raise InputError(f"{name}: expected the code of a key (KeyboardEvent.code)")
    return value


def _place(x: Any, y: Any) -> tuple[float, float]:
    return number(x, "x", 0, 1), number(y, "y", 0, 1)


def _pointer(value: Any) -> Pointer | None:
    if value is None:
        return None
    if len(array(value, "pointer", 3)) != 3:
        raise InputError("pointer: expected x, y and buttons")
    x, y, buttons = value
    return Pointer(*_place(x, y), integer(buttons, "pointer buttons", 0, 2**_MOUSE_BUTTONS - 1))


def _touch(value: Any) -> Touch:
    if len(array(value, "touches", 3)) != 3:
        raise InputError("touches: expected id, x and y")
    identifier, x, y = value
    return Touch(integer(identifier, "touches id", 0, _SAFE), *_place(x, y))


def _gamepad(value: Any) -> Gamepad | None:
    if value is None:
        return None
    if not isinstance(value, dict):
        raise InputError("gamepad: expected an object")
    axes = array(value.get("axes", []), "axes", MAX_AXES)
    buttons = array(value.get("buttons", []), "buttons", MAX_BUTTONS)
    return Gamepad(
        tuple(number(each, "axes", -1, 1) for each in axes), tuple(number(each, "buttons", 0, 1) for each in buttons)
    )


def _key(body: Mapping[str, Any]) -> Key:
    return Key(*_stamp(body), _code(body.get("code"), "code"), truth(body, "down"))


def _button(body: Mapping[str, Any]) -> Button:
    button = integer(body.get("button"), "button", 0, _MOUSE_BUTTONS - 1)
    return Button(*_stamp(body), button, truth(body, "down"), *_place(body.get("x"), body.get("y")))


def _wheel(body: Mapping[str, Any]) -> Wheel:
    turned = number(body.get("dx"), "dx", -_FAR, _FAR), number(body.get("dy"), "dy", -_FAR, _FAR)
    return Wheel(*_stamp(body), *turned, *_place(body.get("x"), body.get("y")))


def _touch_point(body: Mapping[str, Any]) -> TouchPoint:
    touch = _touch([body.get("id"), body.get("x"), body.get("y")])
    return TouchPoint(*_stamp(body), truth(body, "down"), touch)


def _pad(body: Mapping[str, Any]) -> Pad:
    return Pad(*_stamp(body), integer(body.get("button"), "button", 0, MAX_BUTTONS - 1), truth(body, "down"))


def _release(body: Mapping[str, Any]) -> Release:
    why = next((each for each in get_args(Why) if each == body.get("why")), None)
    if why is None:
        raise InputError(f"why: expected one of {', '.join(get_args(Why))}")
    return Release(*_stamp(body), why)


_CHANGES: Final[Mapping[str, Callable[[Mapping[str, Any]], Change]]] = {
    "key": _key,
    "button": _button,
    "wheel": _wheel,
    "touch": _touch_point,
    "pad": _pad,
    "release": _release,
}
