"""The contract of a mind: what it is told, the body that it has meanwhile, and what it does with both. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Protocol, Self

from openrois_agents.tools.answer import Answer
from openrois_agents.tools.vocabulary import Vocabulary

__all__ = ["Mind", "Stage", "Turn"]


@dataclass(frozen=True, slots=True)
class Turn:
    """What a visitor said.

    Attributes:
        text: what was heard; untrusted.
        visitor: its visitor_ref; empty where visitors are not told apart.
        number: within the conversation, from 1.
    """

    text: str
    visitor: str
    number: int


class Stage(Protocol):
    """Where a mind acts: the body that it has."""

    async def say(self, text: str) -> None:
        """Queue a sentence, and return before it is heard; waits while four wait."""
        ...

    async def use(self, tool: str, arguments: Mapping[str, Any]) -> Answer:
        """Use one of the tools; a failure is an answer, too, whose text says why."""
        ...

    async def all_said(self) -> None:
        """Wait until what was queued was heard."""
        ...

    @property
    def heard(self) -> str:
        """What was heard so far of the answer to this turn."""
        ...

    async def vocabulary(self) -> Vocabulary:
        """Return the names that can be chosen now."""
        ...


class Mind(Protocol):
    """Answers what visitors say."""

    @property
    def sends_to(self) -> str:
        """Where words of visitors are sent, as `https://host`; empty where they stay on this machine."""
        ...

    async def __aenter__(self) -> Self: ...

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...

    async def answer(self, turn: Turn, stage: Stage) -> None:
        """Answer a turn; cancelled by an interruption, a STOP and the loss of the body."""
        ...

    def interrupted(self, heard: str) -> None:
        """Note how much was heard of an answer that was cancelled."""
        ...

    def forget(self) -> None:
        """Forget the conversation: it is over."""
        ...
