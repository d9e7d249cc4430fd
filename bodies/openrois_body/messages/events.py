"""Events of an engine about itself: outcomes, lines for the log, and pauses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

from openrois_body.messages.reading import MAX_NAME, MAX_TEXT, LinkError, text, truth

Status: TypeAlias = Literal["OK", "ABORT", "ERROR"]
_STATUSES: Final[Mapping[str, Status]] = {"OK": "OK", "ABORT": "ABORT", "ERROR": "ERROR"}


@dataclass(frozen=True, slots=True)
class Completed:
    """The outcome of a reaction or a walk: done to its end (OK), stopped (ABORT), or not possible (ERROR).

    `reason` says to a person why it was not done to its end; empty where the engine has no more to say.
    """

    id: str
    status: Status
    reason: str = ""

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT; a reason that is too long is cut."""
        said = {"reason": self.reason[:MAX_TEXT]} if self.reason else {}
        return {"event": "completed", "id": self.id, "status": self.status, **said}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Completed:
        """Read the body of EVENT."""
        status = _STATUSES.get(text(body, "status", MAX_NAME))
        if status is None:
            raise LinkError("status: expected OK, ABORT or ERROR")
        reason = text(body, "reason", MAX_TEXT) if "reason" in body else ""
        return cls(text(body, "id", MAX_NAME), status, reason)


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
        return cls(text(body, "text", MAX_TEXT))


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
        return cls(truth(body, "on"))
