"""The JSON messages of the engine link: greeting, commands, events and farewell, checked on the way in.

Every `from_json` takes one decoded JSON object, raises `LinkError` naming the field that is wrong, and ignores members
it does not know, so that a later revision may add some. Every `to_json` gives the object that goes on the wire.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Final, Literal, TypeAlias

MAX_NAME: Final = 200
"""Longest name, version, secret, identifier or reaction, in characters."""
MAX_TEXT: Final = 4_000
"""Longest reason or log text, in characters."""
MAX_REACTIONS: Final = 256
MAX_VISEMES: Final = 2_000
"""Most mouth shapes in one `Speak`: as many as surely fit 64 KiB. Longer speech takes several commands."""
MIN_SIDE: Final = 2
MAX_SIDE: Final = 16_384
"""Smallest and largest width or height of a picture, in pixels."""
MAX_CHANNELS: Final = 2

VISEMES: Final = ("sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "ih", "oh", "ou")
"""The fifteen mouth shapes of the Oculus lip-sync set, as they are written on the wire."""
FORMATS: Final = ("bgra", "i420", "nv12")
"""Pixel formats as HELLO names them."""

Status: TypeAlias = Literal["OK", "ABORT", "ERROR"]
_STATUSES: Final[Mapping[str, Status]] = {"OK": "OK", "ABORT": "ABORT", "ERROR": "ERROR"}
_INT64: Final = 2**63 - 1
_DAY_MS: Final = 86_400_000


class LinkError(Exception):
    """The peer broke the engine link's protocol, refused us, or is gone; the text names what was wrong."""


def _text(body: Mapping[str, Any], name: str, limit: int) -> str:
    value = body.get(name)
    if not isinstance(value, str):
        raise LinkError(f"{name}: expected a string")
    if len(value) > limit:
        raise LinkError(f"{name}: longer than {limit} characters")
    if not value.isascii() and any("\ud800" <= letter <= "\udfff" for letter in value):
        raise LinkError(f"{name}: half of a surrogate pair")
    return value


def _integer(body: Mapping[str, Any], name: str, low: int, high: int) -> int:
    value = body.get(name)
    if not isinstance(value, int) or isinstance(value, bool) or not low <= value <= high:
        raise LinkError(f"{name}: expected an integer from {low} to {high}")
    return value


def _real(value: Any, name: str, low: float, high: float) -> float:
    if not isinstance(value, int | float) or isinstance(value, bool) or not low <= value <= high:
        raise LinkError(f"{name}: expected a number from {low:g} to {high:g}")
    return float(value)


def _truth(body: Mapping[str, Any], name: str) -> bool:
    value = body.get(name)
    if not isinstance(value, bool):
        raise LinkError(f"{name}: expected true or false")
    return value


def _object(body: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    value = body.get(name)
    if not isinstance(value, dict):
        raise LinkError(f"{name}: expected an object")
    return value


@dataclass(frozen=True, slots=True)
class VideoShape:
    """The pictures an engine is going to send; each VIDEO message says again what it carries."""

    width: int
    height: int
    fps: float
    format: str = "bgra"

    def to_json(self) -> dict[str, Any]:
        """The member `video` of HELLO."""
        return {"width": self.width, "height": self.height, "fps": self.fps, "format": self.format}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> VideoShape:
        """Read the member `video` of HELLO."""
        pixel_format = _text(body, "format", MAX_NAME)
        if pixel_format not in FORMATS:
            raise LinkError(f"format: expected one of {', '.join(FORMATS)}")
        width, height = _integer(body, "width", MIN_SIDE, MAX_SIDE), _integer(body, "height", MIN_SIDE, MAX_SIDE)
        return cls(width, height, _real(body.get("fps"), "fps", 0.1, 1000), pixel_format)


@dataclass(frozen=True, slots=True)
class Hello:
    """First message of an engine: who it is, that it knows the secret, and what it can do."""

    name: str
    version: str
    video: VideoShape
    audio_channels: int | None = None
    """Channels of the 48 kHz sound it sends, None if it sends none."""
    reactions: tuple[str, ...] = ()
    secret: str = field(default="", repr=False)
    hears: bool = False
    """Whether it wants AUDIO: the sound of the operator's microphone."""

    def to_json(self) -> dict[str, Any]:
        """The body of HELLO."""
        return {
            "name": self.name,
            "version": self.version,
            "secret": self.secret,
            "video": self.video.to_json(),
            "audio": None if self.audio_channels is None else {"channels": self.audio_channels},
            "reactions": list(self.reactions),
            "hears": self.hears,
        }

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Hello:
        """Read the body of HELLO."""
        channels = None
        if body.get("audio") is not None:
            channels = _integer(_object(body, "audio"), "channels", 1, MAX_CHANNELS)
        names = body.get("reactions")
        if not isinstance(names, list) or len(names) > MAX_REACTIONS:
            raise LinkError(f"reactions: expected an array of at most {MAX_REACTIONS} strings")
        return cls(
            name=_text(body, "name", MAX_NAME),
            version=_text(body, "version", MAX_NAME),
            video=VideoShape.from_json(_object(body, "video")),
            audio_channels=channels,
            reactions=tuple(_text({"reactions": name}, "reactions", MAX_NAME) for name in names),
            secret=_text(body, "secret", MAX_NAME),
            hears="hears" in body and _truth(body, "hears"),
        )


@dataclass(frozen=True, slots=True)
class Welcome:
    """The adapter accepts the engine."""

    name: str

    def to_json(self) -> dict[str, Any]:
        """The body of WELCOME."""
        return {"name": self.name}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Welcome:
        """Read the body of WELCOME."""
        return cls(_text(body, "name", MAX_NAME))


@dataclass(frozen=True, slots=True)
class Bye:
    """The sender closes the connection, for this reason."""

    reason: str

    def to_json(self) -> dict[str, Any]:
        """The body of BYE; a reason that is too long is cut."""
        return {"reason": self.reason[:MAX_TEXT]}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Bye:
        """Read the body of BYE."""
        return cls(_text(body, "reason", MAX_TEXT))


@dataclass(frozen=True, slots=True)
class React:
    """Play a reaction; the engine answers with `Completed` of the same id when it is over."""

    id: str
    reaction: str

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "react", "id": self.id, "reaction": self.reaction}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> React:
        """Read the body of COMMAND."""
        return cls(_text(body, "id", MAX_NAME), _text(body, "reaction", MAX_NAME))


@dataclass(frozen=True, slots=True)
class Viseme:
    """From `offset_ms` on the mouth has `shape` (one of `VISEMES`) with `weight` 0 to 1, until the next one."""

    offset_ms: float
    shape: str
    weight: float

    @classmethod
    def from_json(cls, item: Any) -> Viseme:
        """Read `[offset_ms, shape, weight]`."""
        if not isinstance(item, list) or len(item) != 3:
            raise LinkError("visemes: expected arrays of three: offset_ms, shape, weight")
        offset, shape, weight = item
        if shape not in VISEMES:
            raise LinkError("visemes: unknown shape")
        return cls(_real(offset, "visemes offset_ms", 0, _DAY_MS), shape, _real(weight, "visemes weight", 0, 1))


@dataclass(frozen=True, slots=True)
class Speak:
    """Move the mouth to sound that starts at `start_ns` of CLOCK_MONOTONIC; the sound itself is not on the link.

    Several may be pending at once: each acts from its own `start_ns` on, and `Silence` ends them all.
    """

    id: str
    start_ns: int
    visemes: tuple[Viseme, ...]
    duration_ms: int

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        visemes = [[round(viseme.offset_ms, 1), viseme.shape, round(viseme.weight, 3)] for viseme in self.visemes]
        ident, start, duration = self.id, self.start_ns, self.duration_ms
        return {"command": "speak", "id": ident, "start_ns": start, "visemes": visemes, "duration_ms": duration}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Speak:
        """Read the body of COMMAND; the visemes must be in order of time."""
        items = body.get("visemes")
        if not isinstance(items, list) or len(items) > MAX_VISEMES:
            raise LinkError(f"visemes: expected an array of at most {MAX_VISEMES} items")
        visemes = tuple(Viseme.from_json(item) for item in items)
        if any(later.offset_ms < earlier.offset_ms for earlier, later in pairwise(visemes)):
            raise LinkError("visemes: not in order of time")
        start, duration = _integer(body, "start_ns", 0, _INT64), _integer(body, "duration_ms", 0, _DAY_MS)
        return cls(_text(body, "id", MAX_NAME), start, visemes, duration)


@dataclass(frozen=True, slots=True)
class Silence:
    """Close the mouth now; what was spoken is over."""

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "silence"}

    @classmethod
    def from_json(cls, _body: Mapping[str, Any]) -> Silence:
        """Read the body of COMMAND."""
        return cls()


@dataclass(frozen=True, slots=True)
class Look:
    """Turn the eyes: x from -1 (the viewer's left) to 1, y from -1 (down) to 1."""

    x: float
    y: float

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "look", "x": self.x, "y": self.y}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Look:
        """Read the body of COMMAND."""
        return cls(_real(body.get("x"), "x", -1, 1), _real(body.get("y"), "y", -1, 1))


@dataclass(frozen=True, slots=True)
class Stop:
    """Stop the reaction with this id, or every reaction if it is None; each answers `Completed` with ABORT."""

    id: str | None = None

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "stop", "id": self.id}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Stop:
        """Read the body of COMMAND."""
        return cls(None if body.get("id") is None else _text(body, "id", MAX_NAME))


@dataclass(frozen=True, slots=True)
class Quit:
    """End the engine's process."""

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "quit"}

    @classmethod
    def from_json(cls, _body: Mapping[str, Any]) -> Quit:
        """Read the body of COMMAND."""
        return cls()


@dataclass(frozen=True, slots=True)
class Completed:
    """A reaction is over: played to its end (OK), stopped (ABORT), or not possible (ERROR)."""

    id: str
    status: Status

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT."""
        return {"event": "completed", "id": self.id, "status": self.status}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Completed:
        """Read the body of EVENT."""
        status = _STATUSES.get(_text(body, "status", MAX_NAME))
        if status is None:
            raise LinkError("status: expected OK, ABORT or ERROR")
        return cls(_text(body, "id", MAX_NAME), status)


@dataclass(frozen=True, slots=True)
class Log:
    """One line for the adapter's log."""

    text: str

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT; a text that is too long is cut."""
        return {"event": "log", "text": self.text[:MAX_TEXT]}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Log:
        """Read the body of EVENT."""
        return cls(_text(body, "text", MAX_TEXT))


@dataclass(frozen=True, slots=True)
class Pause:
    """The engine pauses its pictures, or goes on: while it pauses they are not shown and need not come."""

    on: bool

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT."""
        return {"event": "pause", "on": self.on}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Pause:
        """Read the body of EVENT."""
        return cls(_truth(body, "on"))


Command: TypeAlias = React | Speak | Silence | Look | Stop | Quit
Event: TypeAlias = Completed | Log | Pause

_COMMANDS: Final[Mapping[str, Callable[[Mapping[str, Any]], Command]]] = {
    "react": React.from_json,
    "speak": Speak.from_json,
    "silence": Silence.from_json,
    "look": Look.from_json,
    "stop": Stop.from_json,
    "quit": Quit.from_json,
}
_EVENTS: Final[Mapping[str, Callable[[Mapping[str, Any]], Event]]] = {
    "completed": Completed.from_json,
    "log": Log.from_json,
    "pause": Pause.from_json,
}


def command_from_json(body: Mapping[str, Any]) -> Command:
    """The command that the body of a COMMAND message names."""
    read = _COMMANDS.get(_text(body, "command", MAX_NAME))
    if read is None:
        raise LinkError("command: unknown")
    return read(body)


def event_from_json(body: Mapping[str, Any]) -> Event:
    """The event that the body of an EVENT message names."""
    read = _EVENTS.get(_text(body, "event", MAX_NAME))
    if read is None:
        raise LinkError("event: unknown")
    return read(body)
