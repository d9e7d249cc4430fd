"""HELLO, WELCOME and BYE."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from openrois_body.messages.reading import (
    INT64,
    MAX_NAME,
    MAX_TEXT,
    LinkError,
    integer,
    mapping,
    real,
    text,
    truth,
)

MAX_REACTIONS: Final = 256
MAX_VIEWPOINTS: Final = 32
MIN_SIDE: Final = 2
MAX_SIDE: Final = 16_384
"""Smallest and largest width or height of a picture, in pixels."""
MAX_CHANNELS: Final = 2
MAX_SLOTS: Final = 64
MAX_SLOT: Final = 64 * 1024 * 1024
"""Most slots of a ring, and bytes of each."""
SLOT_HEAD: Final = 64
"""Bytes of a slot before its pixels: the lock word, and nothing after it."""
FORMATS: Final = ("bgra", "i420", "nv12", "h264")
"""Formats of pictures as HELLO names them."""


@dataclass(frozen=True, slots=True)
class VideoShape:
    """The pictures that an engine is going to send; each VIDEO message repeats its own shape."""

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
        pixel_format = text(body, "format", MAX_NAME)
        if pixel_format not in FORMATS:
            raise LinkError(f"format: expected one of {', '.join(FORMATS)}, not {pixel_format!r}")
        width, height = integer(body, "width", MIN_SIDE, MAX_SIDE), integer(body, "height", MIN_SIDE, MAX_SIDE)
        return cls(width, height, real(body.get("fps"), "fps", 0.1, 1000), pixel_format)


@dataclass(frozen=True, slots=True)
class Hello:
    """First message of an engine: its name, the secret, and its capabilities."""

    name: str
    version: str
    video: VideoShape
    audio_channels: int | None = None
    """Channels of its 48 kHz sound; None without sound."""
    reactions: tuple[str, ...] = ()
    secret: str = field(default="", repr=False)
    hears: bool = False
    """Whether it takes AUDIO: the sound of the operator's microphone."""
    walks: bool = False
    """Whether its figure walks: it takes `Walk`, `Drive` and `Halt`, and reports its `Place`."""
    ring: bool = False
    """Whether it wants a ring for its pictures: memory that it shares with the adapter."""
    input: bool = False
    """Whether it takes `Input` of the operator's keyboard, mouse, touch and gamepad."""
    demand: bool = False
    """Whether it takes `Demand`, and draws nothing while no pictures are wanted."""

    viewpoints: tuple[str, ...] = ()
    """Its camera positions: the names that `Viewpoint` takes, first the one that it begins with."""

    @property
    def encodes(self) -> bool:
        """Whether its pictures come encoded."""
        return self.video.format == "h264"

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
            "walks": self.walks,
            "ring": self.ring,
            "input": self.input,
            "demand": self.demand,
            "viewpoints": list(self.viewpoints),
        }

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Hello:
        """Read the body of HELLO."""
        channels = None
        if body.get("audio") is not None:
            channels = integer(mapping(body, "audio"), "channels", 1, MAX_CHANNELS)
        return cls(
            name=text(body, "name", MAX_NAME),
            version=text(body, "version", MAX_NAME),
            video=VideoShape.from_json(mapping(body, "video")),
            audio_channels=channels,
            reactions=_names(body.get("reactions"), "reactions", MAX_REACTIONS),
            secret=text(body, "secret", MAX_NAME),
            hears="hears" in body and truth(body, "hears"),
            walks="walks" in body and truth(body, "walks"),
            ring="ring" in body and truth(body, "ring"),
            input="input" in body and truth(body, "input"),
            demand="demand" in body and truth(body, "demand"),
            viewpoints=_names(body.get("viewpoints", []), "viewpoints", MAX_VIEWPOINTS),
        )


def _names(value: Any, name: str, most: int) -> tuple[str, ...]:
    if not isinstance(value, list) or len(value) > most:
        raise LinkError(f"{name}: expected an array of at most {most} strings")
    return tuple(text({name: each}, name, MAX_NAME) for each in value)


@dataclass(frozen=True, slots=True)
class RingPlace:
    """The place of the ring: a file of `slots` times `slot_bytes` bytes, to be mapped."""

    path: str
    slots: int
    slot_bytes: int

    def to_json(self) -> dict[str, Any]:
        """The member `ring` of WELCOME."""
        return {"path": self.path, "slots": self.slots, "slot_bytes": self.slot_bytes}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> RingPlace:
        """Read the member `ring` of WELCOME."""
        slots, slot_bytes = integer(body, "slots", 2, MAX_SLOTS), integer(body, "slot_bytes", SLOT_HEAD, MAX_SLOT)
        if slot_bytes % SLOT_HEAD:
            raise LinkError(f"slot_bytes: expected a multiple of {SLOT_HEAD}")
        return cls(text(body, "path", MAX_TEXT), slots, slot_bytes)


@dataclass(frozen=True, slots=True)
class Welcome:
    """The adapter accepts the engine, and gives it a ring if it asked for one and there is one."""

    name: str
    ring: RingPlace | None = None
    now_ns: int | None = None
    """CLOCK_MONOTONIC when this was sent, for an engine that cannot read it; None if it is left out."""

    def to_json(self) -> dict[str, Any]:
        """The body of WELCOME."""
        ring = None if self.ring is None else self.ring.to_json()
        return {"name": self.name, "ring": ring, **({} if self.now_ns is None else {"now_ns": self.now_ns})}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Welcome:
        """Read the body of WELCOME."""
        ring = None if body.get("ring") is None else RingPlace.from_json(mapping(body, "ring"))
        now_ns = integer(body, "now_ns", 0, INT64) if "now_ns" in body else None
        return cls(text(body, "name", MAX_NAME), ring, now_ns)


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
        return cls(text(body, "reason", MAX_TEXT))
