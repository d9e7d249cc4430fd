"""The command that chooses from where the pictures show the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from openrois_avatar.link.messages.reading import MAX_NAME, text


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
