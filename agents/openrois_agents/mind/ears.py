"""The ears of a mind: the words that all bodies hear, and the grammar by which they are recognised."""

import asyncio
import logging
from collections.abc import Callable, Collection
from contextlib import suppress
from types import TracebackType
from typing import Any, Final, Self

from openrois.aio.tasks import TaskScope
from openrois.catalog.sensing import SPEECH_RECOGNITION
from openrois.client import (
    BodyInfo,
    Client,
    ComponentProxy,
    Subscription,
)
from openrois_agents.mind.expecting import expect_phrases
from openrois_agents.mind.phrases import Phrases
from openrois_agents.mind.words import Words
from openrois_agents.tools.consents import HEARING
from openrois_agents.tools.failures import FAILURES
from openrois_agents.tools.names import Vocabulary
from openrois_agents.tools.session import Session

__all__ = ["Ears", "MakePhrases"]

_log = logging.getLogger(__name__)

_ANYTHING: Final = "default"
_OURS: Final = "grammar mind;"
"""Stands in each grammar of a mind: one that a mind left behind that was killed is not put back."""
_AGAIN: Final = 30.0
"""Seconds after which the bodies are looked at again, where none came or went: places may have."""

MakePhrases = Callable[[Vocabulary, Collection[str]], Phrases]
"""Returns what can be said, given the names that there are and words that a recogniser does not know."""


class Ears:
    """Hears what is said to any body while the block runs, and puts the grammars back at its end.

    Each application that may operate can set the parameters of a sense, as it is not bound: the last one set holds.

    Args:
        session: has the connection.
        heard: told of words.
        make_phrases: what can be said; None where anything can.

    Attributes:
        examples: of what can be said; none where anything can.
    """

    def __init__(self, session: Session, heard: Callable[[Words], None], make_phrases: MakePhrases | None) -> None:
        self._session = session
        self._heard = heard
        self._make_phrases = make_phrases
        self.examples: tuple[str, ...] = ()
        self._tasks = TaskScope()
        self._changed = asyncio.Event()
        self._readers: dict[str, asyncio.Task[None]] = {}
        self._before: dict[str, str] = {}
        """What a recogniser expected before, by its component_ref."""
        self._set: dict[str, tuple[str, str]] = {}
        """The whole grammar, and what of it a recogniser took."""

    async def __aenter__(self) -> Self:
        """Begin to hear.

        Raises:
            ConnectionFailed, ConnectionLost, RoISError, TimeoutError: the bodies cannot be listed.
        """
        self._remove = self._session.profile_changed.add(self._changed.set)
        await self._update()
        self._tasks.start(self._keep_up())
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._remove()
        await self._tasks.__aexit__(kind, error, trace)
        await asyncio.gather(*map(self._put_back, tuple(self._set)))

    async def _keep_up(self) -> None:
        while True:
            try:
                async with asyncio.timeout(_AGAIN):
                    await self._changed.wait()
            except TimeoutError:
                pass
            self._changed.clear()
            try:
                await self._update()
            except FAILURES as error:
                _log.info("the bodies cannot be listed now: %s", error)

    async def _update(self) -> None:
        client = await self._session.link.client()
        bodies = await client.bodies()
        there = {ref: body for body in bodies for ref in body.refs(HEARING)[:1]}
        for ref in [each for each, task in self._readers.items() if task.done() or each not in there]:
            self._readers.pop(ref).cancel()
        for ref, body in there.items():
            if ref not in self._readers:
                occurrences = client.component(ref).event("heard")
                # Subscribed here: what is said from now on is heard.
                await occurrences.__aenter__()
                self._readers[ref] = self._tasks.start(self._read(occurrences, ref, body.engine_id))
        if self._make_phrases is not None:
            await self._expect(client, bodies, self._make_phrases)

    async def _read(self, occurrences: Subscription[dict[str, Any]], component_ref: str, body: str) -> None:
        try:
            async for data in occurrences:
                text, visitor = str(data.get("text", "")), str(data.get("visitor_ref") or "")
                if text or self._make_phrases is not None:
                    self._heard(Words(text, data.get("final") is True, visitor, body))
        except FAILURES as error:
            _log.info("%s is not heard any more: %s", component_ref, error)
            self._changed.set()
        finally:
            with suppress(*FAILURES):
                await occurrences.close()

    async def _expect(self, client: Client, bodies: Collection[BodyInfo], make: MakePhrases) -> None:
        """Let each recogniser expect what can be said now."""
        vocabulary = await self._session.vocabulary()
        phrases = make(vocabulary, ())
        whole, self.examples = phrases.grammar, phrases.examples
        recognisers = [ref for body in bodies for ref in body.refs(SPEECH_RECOGNITION)]
        for ref in [each for each in self._set if each not in recognisers]:
            del self._set[ref]
        for ref in recognisers:
            try:
                await self._expect_at(client.component(ref), whole, lambda unknown: make(vocabulary, unknown))
            except FAILURES as error:
                _log.warning("%s takes no grammar, and recognises anything: %s", ref, error)

    async def _expect_at(
        self, component: ComponentProxy, whole: str, make: Callable[[Collection[str]], Phrases]
    ) -> None:
        ref = component.component_ref
        now = str((await component.get_parameter()).get("grammar", _ANYTHING))
        wanted, taken = self._set.get(ref, ("", ""))
        if now == taken and whole == wanted:
            return
        if taken and now not in (taken, _ANYTHING):
            return  # another application has set it meanwhile

        async def set_grammar(grammar: str) -> None:
            await component.set_parameter(grammar=grammar)

        phrases = await expect_phrases(set_grammar, make)
        self._before.setdefault(ref, _ANYTHING if _OURS in now else now)
        self._set[ref] = (whole, phrases.grammar)

    async def _put_back(self, component_ref: str) -> None:
        """Let a recogniser expect what it did before, unless another application has set it meanwhile."""
        try:
            async with asyncio.timeout(2):
                component = (await self._session.link.client()).component(component_ref)
                if (await component.get_parameter()).get("grammar") == self._set[component_ref][1]:
                    await component.set_parameter(grammar=self._before[component_ref])
        except FAILURES as error:
            _log.info("the grammar of %s was not put back: %s", component_ref, error)
