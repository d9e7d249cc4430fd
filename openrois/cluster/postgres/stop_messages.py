"""What gateways notify each other of a STOP: a question, and an answer in parts that PostgreSQL carries. Pure."""

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Annotated, Any, Final

from pydantic import BaseModel, ConfigDict, Field, ValidationError

__all__ = [
    "MAX_PARTS",
    "MAX_PAYLOAD",
    "AnswerParts",
    "StopAnswer",
    "StopAsked",
    "StopTold",
    "answer_texts",
    "question_text",
    "read_message",
]

MAX_PAYLOAD: Final = 7800
"""Bytes of one notification, beside its topic; PostgreSQL carries 7,999."""

MAX_PARTS: Final = 8
"""Notifications of one answer; components that do not fit in are counted, and not named."""

_MAX_SUBJECT: Final = 256
_MAX_RANK: Final = 64
_MAX_STOP_ID: Final = 64
_MAX_PROBLEM: Final = 200
_ASKED: Final = "asked "
_TOLD: Final = "told "

_Name = Annotated[str, Field(min_length=1, max_length=128)]
_Count = Annotated[int, Field(ge=0, le=1_000_000)]


@dataclass(frozen=True, slots=True)
class StopAnswer:
    """What became of a STOP.

    Attributes:
        stopped: components that have stopped.
        failed: components that have not confirmed it.
        unnamed: how many more there are of both; they are not named.
        problem: why nothing was stopped, or not all; empty where there is nothing to say.
        is_answered: the owner has answered. Without an answer it may have stopped or not.
    """

    stopped: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()
    unnamed: int = 0
    problem: str = ""
    is_answered: bool = True


class _Message(BaseModel):
    """Fields of both; those that a later version adds are left out."""

    model_config = ConfigDict(frozen=True, extra="ignore")

    id: Annotated[str, Field(pattern=r"^[0-9a-f]{32}$")]
    asker: _Name
    owner: _Name


class StopAsked(_Message):
    """A gateway asks the owner of an engine to stop everything on it, for a subject of some rank."""

    engine_id: _Name
    subject: Annotated[str, Field(max_length=_MAX_SUBJECT)]
    rank: Annotated[str, Field(max_length=_MAX_RANK)] = ""
    stop_id: Annotated[str, Field(max_length=_MAX_STOP_ID)] = ""


class StopTold(_Message):
    """A part of the owner's answer."""

    part: Annotated[int, Field(ge=0, lt=MAX_PARTS)]
    parts: Annotated[int, Field(ge=1, le=MAX_PARTS)]
    stopped: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()
    unnamed: _Count = 0
    problem: Annotated[str, Field(max_length=_MAX_PROBLEM)] = ""


@dataclass(slots=True)
class AnswerParts:
    """The parts of one answer that have come.

    Attributes:
        owner: the gateway that was asked.
    """

    owner: str
    _parts: dict[int, StopTold] = field(default_factory=dict)

    def add(self, told: StopTold) -> StopAnswer | None:
        """Add a part; return the answer when it is whole. What another gateway says, or of another number, is none."""
        first = next(iter(self._parts.values()), told)
        if told.owner != self.owner or told.parts != first.parts:
            return None
        self._parts[told.part] = told
        if len(self._parts) < told.parts:
            return None
        parts = [self._parts[each] for each in sorted(self._parts)]
        return StopAnswer(
            stopped=tuple(ref for part in parts for ref in part.stopped),
            failed=tuple(ref for part in parts for ref in part.failed),
            unnamed=sum(part.unnamed for part in parts),
            problem=parts[0].problem,
        )


def question_text(
    question_id: str, asker: str, owner: str, engine_id: str, subject: str, rank: str = "", stop_id: str = ""
) -> str:
    """Return the text of a question.

    Raises:
        ValueError: a name is empty or too long.
    """
    asked = StopAsked(
        id=question_id,
        asker=asker,
        owner=owner,
        engine_id=engine_id,
        subject=subject[:_MAX_SUBJECT],
        rank=rank[:_MAX_RANK],
        stop_id=stop_id[:_MAX_STOP_ID],
    )
    return _ASKED + _written(asked.model_dump())


def answer_texts(asked: StopAsked, answer: StopAnswer) -> list[str]:
    """Return the texts of an answer; what has failed comes first."""
    head = {"id": asked.id, "asker": asked.asker, "owner": asked.owner, "part": 0, "parts": MAX_PARTS, "unnamed": 10**6}
    told: list[dict[str, Any]] = [{"stopped": [], "failed": [], "problem": answer.problem[:_MAX_PROBLEM]}]
    size = room = MAX_PAYLOAD - _size(_TOLD + _written(head | told[0]))
    unnamed = answer.unnamed
    for name, ref in _named(answer):
        needed = _size(_written(ref)) + 2
        if needed > size and needed <= room and len(told) < MAX_PARTS:
            told.append({"stopped": [], "failed": []})
            size = room
        if needed <= size:
            told[-1][name].append(ref)
            size -= needed
        else:
            unnamed += 1
    numbers = {"parts": len(told), "unnamed": 0}
    told[-1]["unnamed"] = unnamed
    return [_TOLD + _written(head | numbers | each | {"part": part}) for part, each in enumerate(told)]


def read_message(text: str) -> StopAsked | StopTold | None:
    """Return what a notification says; None where it is nothing of this kind."""
    try:
        if text.startswith(_ASKED):
            return StopAsked.model_validate_json(text.removeprefix(_ASKED))
        if text.startswith(_TOLD):
            return StopTold.model_validate_json(text.removeprefix(_TOLD))
    except ValidationError:
        pass
    return None


def _named(answer: StopAnswer) -> Iterable[tuple[str, str]]:
    yield from (("failed", ref) for ref in answer.failed)
    yield from (("stopped", ref) for ref in answer.stopped)


def _written(value: object) -> str:
    """Return JSON that a database can hold: half a surrogate pair is written as JSON has it."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")).encode("utf-8", "backslashreplace").decode()


def _size(text: str) -> int:
    return len(text.encode())
