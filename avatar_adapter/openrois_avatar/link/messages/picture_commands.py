"""Commands about an engine's pictures (demand, key frame, bit rate), and the event `idle`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from openrois_body.messages.reading import integer

MAX_CONSUMERS: Final = 1_000_000
"""Most consumers in a message."""
MAX_BITRATE: Final = 1_000_000_000
"""Highest bit rate in a request."""


@dataclass(frozen=True, slots=True)
class Demand:
    """The number of consumers from now on: without any the engine draws nothing, while time, sound and commands go on.

    The first picture after a time without consumers has to be drawn at once.
    """

    consumers: int

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "demand", "consumers": self.consumers}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Demand:
        """Read the body of COMMAND."""
        return cls(integer(body, "consumers", 0, MAX_CONSUMERS))


@dataclass(frozen=True, slots=True)
class Idle:
    """The engine draws nothing, since there is no demand; sent twice a second as a sign of life."""

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT."""
        return {"event": "idle"}

    @classmethod
    def from_json(cls, _body: Mapping[str, Any]) -> Idle:
        """Read the body of EVENT."""
        return cls()


@dataclass(frozen=True, slots=True)
class KeyFrame:
    """Make the next picture a key frame: an IDR picture, with SPS and PPS before it."""

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "key_frame"}

    @classmethod
    def from_json(cls, _body: Mapping[str, Any]) -> KeyFrame:
        """Read the body of COMMAND."""
        return cls()


@dataclass(frozen=True, slots=True)
class Bitrate:
    """Aim at so many bits per second from now on, without a key frame if that can be done."""

    bits_per_second: int

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "bitrate", "bits_per_second": self.bits_per_second}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Bitrate:
        """Read the body of COMMAND."""
        return cls(integer(body, "bits_per_second", 1, MAX_BITRATE))
