"""How many want an engine's pictures, and the sign of life of an engine that draws none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from openrois_avatar.link.messages.reading import integer

MAX_CONSUMERS: Final = 1_000_000
"""Most consumers that can be told of."""


@dataclass(frozen=True, slots=True)
class Demand:
    """So many want pictures from now on: with none the engine draws nothing, while time, sound and commands go on.

    The first picture after none were wanted is to be drawn at once.
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
    """The engine draws nothing, since no pictures are wanted; told twice a second as a sign of life."""

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT."""
        return {"event": "idle"}

    @classmethod
    def from_json(cls, _body: Mapping[str, Any]) -> Idle:
        """Read the body of EVENT."""
        return cls()
