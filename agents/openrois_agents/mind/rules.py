"""A mind without a language model: it understands the sentences of `phrases`, and answers by rules."""

import time
from collections.abc import Callable
from datetime import datetime
from typing import Final, Self

from openrois_agents.mind.contract import Stage, Turn
from openrois_agents.mind.deeds import DEEDS, Acting, Memory
from openrois_agents.mind.phrases import Phrases, make_phrases
from openrois_agents.mind.replies import misunderstood
from openrois_agents.tools.names import Vocabulary

__all__ = ["RuleMind"]

_EXAMPLES: Final = 3
"""Sentences that are named when one was not understood."""
_QUIET: Final = 20.0
"""Seconds after "I did not understand" in which it is not said again: what is heard may be no speech."""


class RuleMind:
    """Answers by rules; a `Mind`. Nothing leaves the machine.

    Args:
        wake_word: with which every sentence begins; empty where none has to. What begins without it is for others.
        clock: monotonic seconds.
        now: the time of day here.
    """

    sends_to = ""
    needs_visitor = False

    def __init__(
        self,
        wake_word: str = "",
        clock: Callable[[], float] = time.monotonic,
        now: Callable[[], datetime] = datetime.now,
    ) -> None:
        self._wake_word = wake_word
        self._now = now
        self._clock = clock
        self._vocabulary = Vocabulary()
        self._phrases = make_phrases(self._vocabulary, wake_word=wake_word)
        self._shown = 0
        """Examples that were named so far."""
        self._begin()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_failure: object) -> None:
        """There is nothing to end."""

    async def answer(self, turn: Turn, stage: Stage) -> None:
        """Do what was asked for, or say that it was not understood."""
        phrases = self._phrases_for(await stage.vocabulary())
        if not phrases.is_addressed(turn.text):
            return
        intent = phrases.understand(turn.text)
        if intent is None:
            await self._name_examples(phrases, stage)
            return
        self._quiet_until = self._clock()
        if intent.name != "repeat":
            self._memory.said = []
        await DEEDS[intent.name](Acting(stage, phrases, self._memory, self._now), intent.argument)

    def interrupted(self, heard: str) -> None:
        """Do nothing: the next answer does not depend on how much of this one was heard."""

    def forget(self) -> None:
        """Forget the conversation."""
        self._begin()

    def _begin(self) -> None:
        self._quiet_until = self._clock()
        self._memory = Memory()

    async def _name_examples(self, phrases: Phrases, stage: Stage) -> None:
        """Say that a sentence was not understood, and some that are; each time others."""
        now = self._clock()
        if now < self._quiet_until:
            return
        self._quiet_until = now + _QUIET
        first = self._shown % len(phrases.examples)
        self._shown = first + _EXAMPLES
        turned = phrases.examples[first:] + phrases.examples[:first]
        await stage.say(misunderstood(turned[:_EXAMPLES]))

    def _phrases_for(self, vocabulary: Vocabulary) -> Phrases:
        if vocabulary != self._vocabulary:
            self._vocabulary = vocabulary
            self._phrases = make_phrases(vocabulary, wake_word=self._wake_word)
        return self._phrases
