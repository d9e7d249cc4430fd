"""What a journal writes down, and how much of it is kept. Pure."""

import json
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

from pydantic import TypeAdapter, ValidationError

from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result

__all__ = [
    "KEPT_FOR",
    "MAX_ENDED",
    "MAX_RESULTS",
    "Accepted",
    "Ended",
    "Presence",
    "Record",
    "Told",
    "read_results",
    "storable",
    "written_results",
]

MAX_ENDED: Final = 4096
"""Ended commands of one gateway that are kept, for applications that were not notified; of more the oldest are dropped.
"""

MAX_RESULTS: Final = 2048
"""Characters of the results of one command that are kept."""

KEPT_FOR: Final = 7 * 86_400.0
"""Seconds for which commands are kept that no application asks about."""

_RESULTS: Final = TypeAdapter(tuple[Result, ...])


@dataclass(frozen=True, slots=True)
class Accepted:
    """A command was accepted, at epoch seconds `at`."""

    session: str
    command_id: str
    subject: str
    component_ref: str
    at: float


@dataclass(frozen=True, slots=True)
class Ended:
    """A command has ended."""

    session: str
    command_id: str
    status: CompletedStatus
    reason: str
    results: tuple[Result, ...]


@dataclass(frozen=True, slots=True)
class Told:
    """The application of a former run's command was notified how it ended."""

    subject: str
    command_id: str


@dataclass(frozen=True, slots=True)
class Presence:
    """An engine was attached or detached."""

    engine_id: str
    is_there: bool


Record = Accepted | Ended | Told | Presence


def storable(text: str) -> str:
    """Return a text that a database can hold in the place of one that it cannot: half a surrogate pair, or a NUL."""
    return text.encode("utf-8", "backslashreplace").decode().replace("\0", "\\x00")


def written_results(results: tuple[Result, ...]) -> str | None:
    """Return results as text; None where they are too long to be kept."""
    text = json.dumps([result.model_dump(mode="json") for result in results])
    return text if len(text) <= MAX_RESULTS else None


def read_results(text: str | None) -> tuple[Result, ...] | None:
    """Return what `written_results` made a text of; None where nothing was kept, or it is damaged."""
    if text is None:
        return None
    with suppress(ValidationError):
        return _RESULTS.validate_json(text)
    return None
