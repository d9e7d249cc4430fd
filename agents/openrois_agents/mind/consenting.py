"""Whether visitors have agreed that a mind gets what they say."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from openrois.client import BodyInfo, Client
from openrois.types.codes import Purpose
from openrois_agents.mind.contract import Allowed, Mind
from openrois_agents.tools.consents import read_visitors

__all__ = ["Consents", "read_consents"]


@dataclass(frozen=True, slots=True)
class Consents:
    """What visitors have consented to.

    Attributes:
        needed: before a mind gets the words of a visitor.
        given: by the references of the visitors who are there.
        needs_visitor: whether words of which a body tells no visitor need consent, too.
    """

    needed: frozenset[Purpose]
    given: Mapping[str, frozenset[str]]
    needs_visitor: bool

    def missing(self, visitor: str) -> tuple[Purpose, ...]:
        """Return what a visitor has to consent to; none where nothing is missing."""
        if not visitor and not self.needs_visitor:
            return ()
        return tuple(sorted(self.needed - self.given.get(visitor, frozenset())))

    def allowed(self, remembered: Collection[str]) -> Allowed:
        """Return what may go to a model that has the words of these visitors. A picture may show all who are there."""
        words = not any(map(self.missing, remembered))
        return Allowed(words, words and not any(map(self.missing, self.given)))


async def read_consents(client: Client, body: BodyInfo, mind: Mind) -> Consents:
    """Return what a mind needs consent to, and what visitors have consented to."""
    needed = {Purpose.AGENT, *((Purpose.TRANSFER,) if mind.sends_to else ())}
    return Consents(frozenset(needed), (await read_visitors(client, body)).consents, mind.needs_visitor)
