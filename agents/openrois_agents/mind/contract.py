"""What a mind is, and where it acts: the seam between a conversation and what answers in it. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol, Self

from openrois_agents.tools.answer import Answer
from openrois_agents.tools.names import Vocabulary

__all__ = ["Allowed", "Mind", "Stage", "Turn"]


@dataclass(frozen=True, slots=True)
class Turn:
    """What a visitor said.

    Attributes:
        text: what was heard; untrusted. Empty where a grammar is expected: speech that is none of its sentences.
        visitor: the visitor's reference; empty where visitors are not told apart.
        number: within the conversation, from 1.
    """

    text: str
    visitor: str
    number: int


@dataclass(frozen=True, slots=True)
class Allowed:
    """What may go to a model now, as visitors consent.

    Attributes:
        words: what was said in this conversation, and what tools told.
        pictures: of the body's camera.
    """

    words: bool
    pictures: bool


class Stage(Protocol):
    """The body in which a mind acts, as long as a conversation lasts."""

    @property
    def heard(self) -> str:
        """What was heard so far of this turn's answer."""
        ...

    async def say(self, text: str) -> None:
        """Queue a sentence; return before it is heard, but wait while four wait already."""
        ...

    async def use(self, tool: str, arguments: Mapping[str, Any]) -> Answer:
        """Call a tool of `openrois_agents.tools`. One that fails is answered too: with why, and the datum `failed`."""
        ...

    async def all_said(self) -> None:
        """Wait until the queued sentences were heard."""
        ...

    async def vocabulary(self) -> Vocabulary:
        """Return the names that can be chosen now."""
        ...

    async def allowed(self) -> Allowed:
        """Ask anew what may go to a model: before each request to it, as visitors may have withdrawn it."""
        ...


class Mind(Protocol):
    """What answers in a conversation.

    Attributes:
        sends_to: where words of visitors are sent, as `https://host`; empty where they stay on this machine.
        needs_visitor: whether it takes the words of visitors alone, who can consent, and none that a body hears with a
            microphone of its own.
    """

    sends_to: str
    needs_visitor: bool

    async def __aenter__(self) -> Self: ...

    async def __aexit__(self, *failure: object) -> None: ...

    async def answer(self, turn: Turn, stage: Stage) -> None:
        """Answer a turn. It is cancelled by an interruption, by a person's STOP, and where the body is lost."""
        ...

    def interrupted(self, heard: str) -> None:
        """Note how much of an answer was heard that was cancelled."""
        ...

    def forget(self) -> None:
        """Forget the conversation: it is over."""
        ...
