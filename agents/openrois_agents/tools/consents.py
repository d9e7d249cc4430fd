"""What the visitors of a body consent to, and what an agent may be told of them."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any, Final

from openrois.catalog.sensing import SPEECH_RECOGNITION
from openrois.client import BodyInfo, Client, ConnectionFailed, ConnectionLost, RoISError, RpcError
from openrois.types.codes import Purpose
from openrois.types.profiles import component_urn

__all__ = ["VisitorsNow", "may_be_told", "read_visitors"]

_log = logging.getLogger(__name__)

_VISITORS: Final = component_urn("Visitors", "OpenRoIS")


@dataclass(frozen=True, slots=True)
class VisitorsNow:
    """The visitors of a body.

    Attributes:
        consents: what each of them consents to, by their references.
        attended: the reference of the one whom the senses follow; empty for none.
        are_known: whether the body tells its visitors; what it does not tell is not assumed.
    """

    consents: Mapping[str, frozenset[str]]
    attended: str = ""
    are_known: bool = True

    @property
    def without_agents(self) -> list[str]:
        """The visitors who do not consent to agents."""
        return sorted(visitor for visitor, given in self.consents.items() if Purpose.AGENT not in given)


async def read_visitors(client: Client, body: BodyInfo) -> VisitorsNow:
    """Ask a body for its visitors; one that tells none apart has none."""
    for component_ref in body.refs(_VISITORS)[:1]:
        try:
            found = await client.component(component_ref).query("visitors")
        except (ConnectionFailed, ConnectionLost, RoISError, RpcError, TimeoutError) as error:
            _log.warning("%s does not tell what visitors consent to: %s", body.engine_id, error)
            return VisitorsNow({}, are_known=False)
        refs, consents = found.get("visitor_ref", ()), found.get("consent", ())
        # A visitor of whom no consent is told has given none.
        told = zip_longest(refs, consents[: len(refs)], fillvalue="")
        given = {visitor: frozenset(str(each).split()) for visitor, each in told}
        return VisitorsNow(given, str(found.get("attended", "")))
    return VisitorsNow({})


async def may_be_told(client: Client, body: BodyInfo, component_ref: str, data: Mapping[str, Any]) -> bool:
    """Tell whether an agent may have an event: what a visitor said or did, with that visitor's consent to agents.

    Who comes and goes, and consents to what, is told in any case. An event of `SpeechRecognition` names no visitor: its
    words are those of the one whom the senses follow.
    """
    named = data.get("visitor_ref")
    has_words = component_ref in body.refs(SPEECH_RECOGNITION.urn)
    if component_ref in body.refs(_VISITORS) or not (named or has_words):
        return True
    now = await read_visitors(client, body)
    visitor = named or now.attended
    return Purpose.AGENT in now.consents.get(visitor, ()) if visitor else now.are_known
