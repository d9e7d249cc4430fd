"""The voice of a body while a conversation lasts: it yields to visitors, and tells how much of a sentence was heard."""

import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.client import Subscription
from openrois.types.profiles import component_urn
from openrois_agents.tools.failures import FAILURES
from openrois_agents.tools.held_body import HeldBody

__all__ = ["Spoken", "yield_again", "yielding_voice"]

_log = logging.getLogger(__name__)

_SPEECH_PROGRESS: Final = component_urn("SpeechProgress", "OpenRoIS")


class Spoken:
    """How much of the sentence that is being said was heard."""

    def __init__(self) -> None:
        self._end = 0

    def begin_sentence(self) -> None:
        """Begin another sentence."""
        self._end = 0

    def add_word(self, position: int, length: int) -> None:
        """Note a word that is heard."""
        self._end = max(self._end, position + length)

    def heard_of(self, sentence: str) -> str:
        """Return what was heard of the sentence that is being said."""
        return sentence[: self._end]


@asynccontextmanager
async def yielding_voice(held: HeldBody) -> AsyncIterator[Spoken]:
    """Let speech stop while the block runs when a visitor speaks to the body, where the body can."""
    spoken = Spoken()
    component_ref = next(iter(held.info.refs(_SPEECH_PROGRESS)), None)
    if component_ref is None:
        yield spoken
        return
    async with TaskScope() as tasks:
        try:
            component = await held.bind(component_ref)
            await component.set_parameter(barge_in=True)
        except FAILURES as error:
            _log.info("%s does not stop when it is spoken to: %s", held.engine_id, error)
            yield spoken
            return
        tasks.start(_read_words(component.event("word_spoken"), spoken))
        try:
            yield spoken
        finally:
            if held.body.error is None:
                try:
                    await component.set_parameter(barge_in=False)
                except FAILURES as error:
                    _log.info("barge_in of %s may still be set: %s", component_ref, error)


async def _read_words(words: Subscription[dict[str, Any]], spoken: Spoken) -> None:
    try:
        async with words:
            async for data in words:
                spoken.add_word(int(data["position"]), int(data["length"]))
    except FAILURES as error:
        _log.info("how much is heard is not known: %s", error)


async def yield_again(held: HeldBody, came_back: str) -> None:
    """Let speech stop again when a visitor speaks, where the component that was lent and came back is what does so."""
    for component_ref in held.info.refs(_SPEECH_PROGRESS)[:1]:
        if component_ref == came_back:
            try:
                await (await held.bind(component_ref)).set_parameter(barge_in=True)
            except FAILURES as error:
                _log.info("%s does not stop when it is spoken to: %s", held.engine_id, error)
