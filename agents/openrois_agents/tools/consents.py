"""What the visitors of a body consent to, and what an agent may be told of them."""

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any, Final

from openrois.catalog import sensing
from openrois.client import BodyInfo, Client
from openrois.types.codes import Purpose
from openrois.types.profiles import component_urn
from openrois_agents.tools.failures import FAILURES

__all__ = ["HEARING", "TELLING_QUERIES", "VISITORS", "Consents", "VisitorsNow", "read_statement", "read_visitors"]

_log = logging.getLogger(__name__)

VISITORS: Final = component_urn("Visitors", "OpenRoIS")
HEARING: Final = component_urn("Hearing", "OpenRoIS")
_SENSES: Final = (
    sensing.PERSON_DETECTION.urn,
    sensing.PERSON_LOCALIZATION.urn,
    sensing.PERSON_IDENTIFICATION.urn,
    sensing.FACE_DETECTION.urn,
    sensing.FACE_LOCALIZATION.urn,
    sensing.SOUND_DETECTION.urn,
    sensing.SOUND_LOCALIZATION.urn,
    sensing.SPEECH_RECOGNITION.urn,
    sensing.GESTURE_RECOGNITION.urn,
    HEARING,
    component_urn("Sight", "OpenRoIS"),
)
"""Types whose events tell of persons; those of the standard do not say of whom."""

_COMING_AND_GOING: Final = frozenset({"visitor_changed", "attended"})
"""Events of Visitors that tell no more of a visitor than the query that anyone may make."""

TELLING_QUERIES: Final = frozenset({"last_heard"})
"""Queries of Hearing whose results tell of visitors."""

MAX_REMEMBERED: Final = 64
"""Visitors of a body whose consent is remembered; the one that was there longest ago is forgotten."""


@dataclass(frozen=True, slots=True)
class VisitorsNow:
    """The visitors of a body.

    Attributes:
        consents: what each of them consents to, by their references.
        are_known: whether the body tells its visitors; what it does not tell is not assumed.
    """

    consents: Mapping[str, frozenset[str]]
    are_known: bool = True

    @property
    def without_agents(self) -> list[str]:
        """The visitors who do not consent to agents."""
        return sorted(visitor for visitor, given in self.consents.items() if Purpose.AGENT not in given)


async def read_visitors(client: Client, body: BodyInfo) -> VisitorsNow:
    """Ask a body for its visitors; one that tells none apart has none."""
    for component_ref in body.refs(VISITORS)[:1]:
        try:
            found = await client.component(component_ref).query("visitors")
        except FAILURES as error:
            _log.warning("%s does not tell what visitors consent to: %s", body.engine_id, error)
            return VisitorsNow({}, are_known=False)
        refs, consents = found.get("visitor_ref", ()), found.get("consent", ())
        # A visitor of whom no consent is told has given none.
        told = zip_longest(refs, consents[: len(refs)], fillvalue="")
        return VisitorsNow({visitor: _purposes(each) for visitor, each in told})
    return VisitorsNow({})


def read_statement(change: Mapping[str, Any]) -> Mapping[str, frozenset[str]]:
    """Return what the visitor of a `visitor_changed` consents to; of one who has left nothing: it withdraws nothing."""
    return {str(change.get("visitor_ref", "")): _purposes(change.get("consent", ""))} if change.get("devices") else {}


def _purposes(told: object) -> frozenset[str]:
    return frozenset(str(told).split())


class Consents:
    """Asks whether an agent may be told what visitors of a body say and do. A visitor who leaves withdraws nothing.

    Args:
        client: asks.
        body: whose visitors.

    Attributes:
        withheld: whether something was not told since that was last set to False.
    """

    def __init__(self, client: Client, body: BodyInfo) -> None:
        self.withheld = False
        self._client = client
        self._body = body
        self._stated: dict[str, frozenset[str]] = {}
        self._senses = {ref for urn in _SENSES for ref in body.refs(urn)}

    async def _read(self) -> VisitorsNow:
        """Ask for the visitors who are there."""
        now = await read_visitors(self._client, self._body)
        self._note(now.consents)
        return now

    async def follow(self) -> None:
        """Note what visitors state until cancelled: one may withdraw everything and leave at once."""
        for component_ref in self._body.refs(VISITORS)[:1]:
            async for data in self._client.component(component_ref).event("visitor_changed"):
                self._note(read_statement(data))

    def _note(self, consents: Mapping[str, frozenset[str]]) -> None:
        for visitor, given in consents.items():
            self._stated.pop(visitor, None)
            self._stated[visitor] = given
        while len(self._stated) > MAX_REMEMBERED:
            del self._stated[next(iter(self._stated))]

    def concern(self, component_ref: str, event: str, data: Mapping[str, Any]) -> bool:
        """Return whether an event tells of persons."""
        if component_ref in self._body.refs(VISITORS) and event in _COMING_AND_GOING:
            return False
        return component_ref in self._senses or bool(data.get("visitor_ref"))

    def concern_query(self, component_ref: str, query: str) -> bool:
        """Return whether the results of a query tell of persons."""
        return component_ref in self._body.refs(HEARING) and query in TELLING_QUERIES

    async def ask(self) -> Callable[[Mapping[str, Any]], bool]:
        """Ask once; return what says of the data of events whether they may be told.

        What names a visitor needs the consent of that one, what names none that of all who are there.
        """
        now = await self._read()

        def may_be_told(data: Mapping[str, Any]) -> bool:
            visitor = data.get("visitor_ref")
            if isinstance(visitor, str) and visitor:
                agrees = Purpose.AGENT in self._stated.get(visitor, ())
            else:
                agrees = not now.without_agents
            self.withheld |= not (agrees and now.are_known)
            return agrees and now.are_known

        return may_be_told
