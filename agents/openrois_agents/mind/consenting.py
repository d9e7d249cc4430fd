"""Whether visitors have agreed that a mind gets what they say."""

import logging
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from typing import Final

from openrois.client import BodyInfo, Client, ConnectionFailed, ConnectionLost, RoISError, RpcError
from openrois.types.codes import Purpose
from openrois.types.profiles import component_urn
from openrois_agents.mind.contract import Allowed, Mind

__all__ = ["Consents", "read_consents"]

_log = logging.getLogger(__name__)

_VISITORS: Final = component_urn("Visitors", "OpenRoIS")


@dataclass(frozen=True, slots=True)
class Consents:
    """What visitors have consented to.

    Attributes:
        needed: before a mind gets the words of a visitor.
        given: by the references of the visitors who are there.
    """

    needed: frozenset[str]
    given: Mapping[str, frozenset[str]]

    def missing(self, visitor: str) -> tuple[str, ...]:
        """Return what a visitor has to consent to; none where nothing is missing."""
        return tuple(sorted(self.needed - self.given.get(visitor, frozenset())))

    def allowed(self, remembered: Collection[str]) -> Allowed:
        """Return what may go to a model that has the words of these visitors. A picture may show all who are there."""
        words = not any(map(self.missing, remembered))
        return Allowed(words, words and not any(map(self.missing, self.given)))


async def read_consents(client: Client, body: BodyInfo, mind: Mind) -> Consents:
    """Ask a body what its visitors consent to; where it does not tell that, none of it is taken for granted."""
    if not mind.needs_consent:
        return Consents(frozenset(), {})
    needed = frozenset({Purpose.AGENT.value, *((Purpose.TRANSFER.value,) if mind.sends_to else ())})
    given: dict[str, frozenset[str]] = {}
    for component_ref in body.refs(_VISITORS)[:1]:
        try:
            found = await client.component(component_ref).query("visitors")
        except (ConnectionFailed, ConnectionLost, RoISError, RpcError, TimeoutError) as error:
            _log.warning("%s does not tell what visitors consent to: %s", body.engine_id, error)
            continue
        refs, consents = found.get("visitor_ref", ()), found.get("consent", ())
        # A visitor of whom no consent is told has given none.
        told = zip_longest(refs, consents[: len(refs)], fillvalue="")
        given = {visitor: frozenset(str(each).split()) for visitor, each in told}
    return Consents(needed, given)
