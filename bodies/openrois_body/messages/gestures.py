"""Commands to the figure where it stands: gestures, speech and gaze; and to the engine: viewpoint, stop, quit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

from openrois_body.messages.reading import INT64, MAX_NAME, LinkError, integer, mapping, real, text

MAX_VISEMES: Final = 2_000
"""Most mouth shapes in one `Speak`: as many as surely fit 64 KiB. Longer speech takes several commands."""
VISEMES: Final = ("sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "ih", "oh", "ou")
"""The fifteen mouth shapes of the Oculus lip-sync set, as they are written on the wire."""
_DAY_MS: Final = 86_400_000


@dataclass(frozen=True, slots=True)
class React:
    """Play a reaction; the engine sends `Completed` with the same id when it has ended."""

    id: str
    reaction: str

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "react", "id": self.id, "reaction": self.reaction}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> React:
        """Read the body of COMMAND."""
        return cls(text(body, "id", MAX_NAME), text(body, "reaction", MAX_NAME))


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
        return cls(real(offset, "visemes offset_ms", 0, _DAY_MS), shape, real(weight, "visemes weight", 0, 1))


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
        start, duration = integer(body, "start_ns", 0, INT64), integer(body, "duration_ms", 0, _DAY_MS)
        return cls(text(body, "id", MAX_NAME), start, visemes, duration)


@dataclass(frozen=True, slots=True)
class Silence:
    """Close the mouth now; every `Speak` ends."""

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
        return cls(real(body.get("x"), "x", -1, 1), real(body.get("y"), "y", -1, 1))


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
        return cls(None if body.get("id") is None else text(body, "id", MAX_NAME))


@dataclass(frozen=True, slots=True)
class Input:
    """Input of the operator by keyboard, mouse, touch or gamepad: the application's message, checked."""

    message: Mapping[str, Any]

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "input", "message": dict(self.message)}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Input:
        """Read the body of COMMAND; the message in it is as `docs/reference/wire.md` says, and not checked again."""
        return cls(mapping(body, "message"))


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
class Viewpoint:
    """Show the scene from one of the viewpoints that HELLO names, from now on."""

    name: str

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "viewpoint", "viewpoint": self.name}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Viewpoint:
        """Read the body of COMMAND."""
        return cls(text(body, "viewpoint", MAX_NAME))
