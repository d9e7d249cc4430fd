"""Commands to an engine that encodes its pictures itself: what its encoder has to do for those who look."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from openrois_avatar.link.messages.reading import integer

MAX_BITRATE: Final = 1_000_000_000
"""Most bits per second that can be asked for."""


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
