"""A record of an engine's pictures, sound and events, without pixels and samples."""

from collections import deque
from dataclasses import dataclass, field
from typing import Final

from openrois_avatar.link.media import Audio, Doorbell, Encoded, Video
from openrois_avatar.link.messages import Event

__all__ = ["Block", "EventRecord", "Picture", "Record"]

_KEPT: Final = 100_000
"""Most entries of each kind; the oldest are dropped."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture: time of arrival and timestamp, in seconds of CLOCK_MONOTONIC."""

    at: float
    claimed: float
    sequence: int
    size: tuple[int, int]
    format: str
    in_ring: bool = False
    keyframe: bool = False


@dataclass(frozen=True, slots=True)
class Block:
    """A block of sound: time of arrival and timestamp, in seconds of CLOCK_MONOTONIC."""

    at: float
    claimed: float
    sequence: int
    channels: int
    seconds: float


@dataclass(frozen=True, slots=True)
class EventRecord:
    """An event and its time of arrival."""

    at: float
    event: Event


@dataclass(frozen=True, slots=True)
class Record:
    """All messages of one connection, in order."""

    pictures: deque[Picture] = field(default_factory=lambda: deque(maxlen=_KEPT))
    blocks: deque[Block] = field(default_factory=lambda: deque(maxlen=_KEPT))
    events: deque[EventRecord] = field(default_factory=lambda: deque(maxlen=_KEPT))

    def add_message(self, message: Video | Encoded | Doorbell | Audio | Event, at: float) -> None:
        """Record a message that arrived at that moment."""
        match message:
            case Video() | Doorbell():
                size, claimed = (message.width, message.height), message.timestamp_ns / 1e9
                in_ring = isinstance(message, Doorbell)
                name = message.format.name.lower()
                self.pictures.append(Picture(at, claimed, message.sequence, size, name, in_ring))
            case Encoded():
                size, claimed = (message.width, message.height), message.timestamp_ns / 1e9
                self.pictures.append(Picture(at, claimed, message.sequence, size, "h264", keyframe=message.keyframe))
            case Audio():
                samples = len(message.samples) // (2 * message.channels)
                claimed, seconds = message.timestamp_ns / 1e9, samples / 48_000
                self.blocks.append(Block(at, claimed, message.sequence, message.channels, seconds))
            case _:
                self.events.append(EventRecord(at, message))
