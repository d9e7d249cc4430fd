"""Conversations in tests: a mind that does as it is told, before a real gateway and a body."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any, Self

from openrois_agents.mind.contract import Stage, Turn
from openrois_agents.mind.conversation import Conversations
from openrois_agents.mind.ears import Ears, MakePhrases
from openrois_agents.mind.figures import MindFigures
from openrois_agents.mind.limits import Budget, Limits
from openrois_agents.mind.phrases import Phrases, make_phrases
from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.session import Session
from openrois_agents.tools.settings import ToolSettings

from openrois.adapter import Component, event, parameter
from openrois.client import Client
from openrois.testing import memory_gateway
from tests.support.actors import Actor, Words
from tests.support.clock import Clock

__all__ = [
    "MUCH",
    "PATIENCE",
    "Conversing",
    "Recognition",
    "ScriptedMind",
    "SpeechProgress",
    "conversing",
    "no_phrases",
    "talk",
    "until",
]

PATIENCE = 30.0
MUCH = Limits(100, 1_000, 10_000.0)


class SpeechProgress(Component, authority="OpenRoIS", function="actuation", part="voice"):
    barge_in: bool = parameter(False)

    @event
    def word_spoken(self, speech_id: str, word: str, position: int, length: int, spoken_at: datetime) -> None: ...


class Recognition(Words):
    grammar: str = parameter("default")


class ScriptedMind:
    """A `Mind` that calls a function of a test."""

    def __init__(self, sends_to: str = "", needs_visitor: bool = False) -> None:
        self.sends_to = sends_to
        self.needs_visitor = needs_visitor
        self.turns: list[Turn] = []
        self.cut: list[str] = []
        self.forgotten = 0
        self.script: Callable[[Turn, Stage], Awaitable[Any]] = _echo

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_failure: object) -> None: ...

    async def answer(self, turn: Turn, stage: Stage) -> None:
        self.turns.append(turn)
        await self.script(turn, stage)

    def interrupted(self, heard: str) -> None:
        self.cut.append(heard)

    def forget(self) -> None:
        self.forgotten += 1


async def _echo(turn: Turn, stage: Stage) -> None:
    await stage.say(f"You said {turn.text}.")


@dataclass
class Conversing:
    """A mind at work, its body, and the clock of its conversations."""

    mind: ScriptedMind
    actor: Actor
    clock: Clock
    figures: MindFigures
    session: Session
    ticks: asyncio.Queue[None]
    conversations: Conversations

    def hear(self, text: str, *, final: bool = True, visitor: str | None = None) -> None:
        """Let the body hear words."""
        self.actor.hearing.heard(text, final, None, visitor)

    async def until_free(self) -> None:
        """Wait until the conversation is over; it looks at its clock meanwhile."""

        def is_over() -> bool:
            if self.ticks.empty():
                self.ticks.put_nowait(None)
            return self.figures.holds == 0

        await until(is_over)


async def until(holds: Callable[[], bool]) -> None:
    """Wait until something holds."""
    async with asyncio.timeout(PATIENCE):
        while not holds():  # noqa: ASYNC110 - some of it is told by no event
            await asyncio.sleep(0)


@asynccontextmanager
async def conversing(
    make_client: Callable[[], Client],
    actor: Actor,
    *,
    mind: ScriptedMind | None = None,
    limits: tuple[Limits, Limits] = (MUCH, MUCH),
    wake_word: str = "",
    make_phrases: MakePhrases | None = None,
) -> AsyncIterator[Conversing]:
    """Lead conversations while the block runs; the time of the clock is looked at for each item of `ticks`."""
    clock, figures, ticks = Clock(), MindFigures(), asyncio.Queue[None]()
    mind = mind or ScriptedMind()

    async def pause(_seconds: float) -> None:
        await ticks.get()

    async with Session(make_client, ToolSettings(), clock) as session:
        budget = Budget(*limits, lambda: date(2026, 1, 1))
        conversations = Conversations(session, mind, budget, figures, wake_word, lambda: ears.examples, pause)
        ears = Ears(session, conversations.hear, make_phrases)
        async with ears:
            running = asyncio.ensure_future(conversations.run())
            try:
                yield Conversing(mind, actor, clock, figures, session, ticks, conversations)
            finally:
                running.cancel()
                await asyncio.wait({running})


def no_phrases(_names: object, _unknown: object) -> Phrases:
    """Make a grammar in which nothing can be said."""
    return make_phrases(Vocabulary())


@asynccontextmanager
async def talk(*more: Component, at_once: bool = True, **options: Any) -> AsyncIterator[Conversing]:
    """Lead conversations with a body that has these components, too, behind a gateway in memory."""
    actor = Actor(at_once)
    async with memory_gateway(*actor.parts, *more) as gateway, conversing(gateway.client, actor, **options) as talking:
        yield talking
