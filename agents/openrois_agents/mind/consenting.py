"""Whether visitors have agreed that a mind gets what they say, and who was asked to."""

import logging
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any, Final

from openrois.aio.tasks import TaskScope
from openrois.client import BodyInfo, Client, Subscription
from openrois.types.codes import Purpose
from openrois_agents.mind.contract import Allowed, Mind
from openrois_agents.mind.figures import MindFigures
from openrois_agents.mind.words import Words
from openrois_agents.tools.consents import VISITORS, read_statement, read_visitors
from openrois_agents.tools.failures import FAILURES
from openrois_agents.tools.session import Session

__all__ = ["Asked", "Consents", "Remembered", "request_consent"]

_log = logging.getLogger(__name__)

_ASKED: Final = {
    Purpose.AGENT: "a program that answers gets your words",
    Purpose.TRANSFER: "they are sent to another machine",
}
_MOST_ASKED: Final = 64
"""Visitors of whom it is remembered that they were asked; the first one makes room."""


@dataclass(frozen=True, slots=True)
class Consents:
    """What visitors have consented to.

    Attributes:
        needed: before a mind gets the words of a visitor.
        given: by the references of the visitors who are there.
        left: what those stated last whose words the mind has, and who have left; none where the body does not tell.
        needs_visitor: whether words of which a body tells no visitor need consent, too.
    """

    needed: frozenset[Purpose]
    given: Mapping[str, frozenset[str]]
    left: Mapping[str, frozenset[str]]
    needs_visitor: bool

    def missing(self, visitor: str) -> tuple[Purpose, ...]:
        """Return what a visitor has to consent to; none where nothing is missing."""
        if not visitor and not self.needs_visitor:
            return ()
        stated = self.given.get(visitor, self.left.get(visitor, frozenset()))
        return tuple(sorted(self.needed - stated))


class Remembered:
    """The visitors whose words a mind has, and what each of them has stated last.

    A visitor who has left has withdrawn nothing: what was said with its consent may go on to be used in the turn that
    answers it. One who is there counts by what it states now.

    Args:
        mind: has their words.
    """

    def __init__(self, mind: Mind) -> None:
        self._mind = mind
        self._stated: dict[str, frozenset[str]] = {}

    async def read_consents(self, client: Client, body: BodyInfo) -> Consents:
        """Ask a body what its visitors consent to, and remember what those have stated whose words the mind has."""
        now = await read_visitors(client, body)
        self._note(now.consents)
        gone = {visitor: stated for visitor, stated in self._stated.items() if visitor and visitor not in now.consents}
        needed = {Purpose.AGENT, *((Purpose.TRANSFER,) if self._mind.sends_to else ())}
        return Consents(frozenset(needed), now.consents, gone if now.are_known else {}, self._mind.needs_visitor)

    async def read_consents_at(self, session: Session, body: str) -> Consents | None:
        """Ask a body that was spoken to; None where there is none to be asked any more."""
        try:
            return await self.read_consents(await session.link.client(), await session.body_info(body))
        except FAILURES as error:
            _log.info("%s was spoken to, and cannot answer: %s", body, error)
            return None

    def add(self, visitor: str, consents: Consents) -> None:
        """Remember a visitor whose words the mind gets."""
        self._stated[visitor] = consents.given.get(visitor, consents.left.get(visitor, frozenset()))

    def forget_visitors(self) -> None:
        """Remember none: the mind has forgotten what they said."""
        self._stated.clear()

    def allowed(self, consents: Consents) -> Allowed:
        """Return what may go to a model that has their words. A picture may show all who are there."""
        words = not any(map(consents.missing, self._stated))
        return Allowed(words, words and not any(map(consents.missing, consents.given)))

    def may_stay(self, consents: Consents, speaker: str) -> bool:
        """Tell whether their words may be told again with those of a speaker: not those of another one who has left."""
        return not any(consents.missing(each) or (each != speaker and each in consents.left) for each in self._stated)

    @asynccontextmanager
    async def following(self, client: Client, body: BodyInfo) -> AsyncIterator[None]:
        """Note while the block runs what visitors of a body state, also just before they leave."""
        async with TaskScope() as tasks:
            for component_ref in body.refs(VISITORS)[:1]:
                changes = client.component(component_ref).event("visitor_changed")
                try:
                    # Subscribed here: no withdrawal from now on is missed.
                    await changes.__aenter__()
                except FAILURES as error:
                    _log.warning("what visitors of %s withdraw as they leave is not heard: %s", body.engine_id, error)
                else:
                    tasks.start(self._note_all(changes))
            yield

    def _note(self, consents: Mapping[str, frozenset[str]]) -> None:
        self._stated |= {visitor: given for visitor, given in consents.items() if visitor in self._stated}

    async def _note_all(self, changes: Subscription[dict[str, Any]]) -> None:
        try:
            async for data in changes:
                self._note(read_statement(data))
        except FAILURES as error:
            _log.info("what visitors withdraw as they leave is not heard any more: %s", error)
        finally:
            await changes.close()


class Asked:
    """Visitors who were asked for the consent that is missing, and have not given it: each is asked once.

    Args:
        clock: monotonic seconds.
        silence: seconds without words of a visitor after which it may be asked again, where no conversation lasts.
        figures: are counted.
    """

    def __init__(self, clock: Callable[[], float], silence: float, figures: MindFigures) -> None:
        self._clock = clock
        self._silence = silence
        self._figures = figures
        self._asked: dict[str, tuple[Sequence[Purpose], float]] = {}
        """For what, and when it spoke last, by the reference of the visitor."""

    def add(self, visitor: str, missing: Sequence[Purpose]) -> None:
        """Note that a visitor was asked."""
        self._asked.pop(visitor, None)
        self._asked[visitor] = missing, self._clock()
        if len(self._asked) > _MOST_ASKED:
            del self._asked[next(iter(self._asked))]

    def discard(self, visitor: str) -> None:
        """Forget that a visitor was asked: it has consented."""
        self._asked.pop(visitor, None)

    def passes_over(self, words: Words, missing: Sequence[Purpose], *, lasts: bool) -> bool:
        """Return whether words need no answer: of a visitor who was asked already, or what may be no speech.

        Args:
            words: of a visitor.
            missing: what it has to consent to.
            lasts: whether a conversation does.
        """
        if not missing or not words.text:
            return bool(missing)
        before, at = self._asked.get(words.visitor, ((), 0.0))
        if before != missing or not (lasts or self._clock() - at <= self._silence):
            return False
        self._figures.refusals["consent"] += 1
        self.add(words.visitor, missing)
        return True


def request_consent(missing: Sequence[Purpose]) -> str:
    """Return what a visitor is told who has to consent to something."""
    asked = " and that ".join(_ASKED[each] for each in missing)
    return f"I may only answer you if you agree that {asked}: please do so where your microphone is."
