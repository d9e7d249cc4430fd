"""Visitors: who sends to a body, what each consents to, whom the body attends to. A component of OpenRoIS."""

from collections.abc import Iterable
from functools import partial
from typing import Annotated, Any, Final

from openrois_media.visitors.registry import VisitorRegistry
from openrois_media.visitors.visitor import Visitor
from pydantic import Field

from openrois.adapter import BadParameter, Component, Payload, event, parameter, query
from openrois.types.codes import Purpose
from openrois.types.references import reference
from openrois_body.attention.attention import Attention
from openrois_body.attention.rule import LOUDEST, NEAREST
from openrois_body.components.sensing import Sense

__all__ = ["Visitors"]

_RECOGNITION: Final = frozenset({Purpose.RECOGNITION})
_MODES: Final = (NEAREST, LOUDEST)


class VisitorsResult(Payload):
    """Who sends now, the first that came first: for each what it sends and what it consents to, in one text each.

    `attended` is the visitor_ref of who is attended to; empty for none.
    """

    visitor_ref: tuple[str, ...]
    devices: tuple[str, ...]
    consent: tuple[str, ...]
    attended: str


class Visitors(Component, authority="OpenRoIS", function="sensing"):
    """Tells who visits a body, and of whom the senses tell; the senses follow the visitor that is attended to.

    Args:
        engine_id: leads the refs of the senses.
        visitors: of the body.
        attention: chooses one of them.
        senses: the components whose events tell of visitors.
    """

    attention: Annotated[str, Field(max_length=256)] = parameter(
        NEAREST, description="whom the senses follow: nearest (face), loudest (voice), or a visitor_ref"
    )

    def __init__(
        self, engine_id: str, visitors: VisitorRegistry, attention: Attention, senses: Iterable[Component] = ()
    ) -> None:
        super().__init__()
        self._visitors = visitors
        self._attention = attention
        self._told: dict[str, tuple[str, str]] = {}
        visitors.changed.add(self._on_changed)
        attention.attended_changed.add(self.attended)
        for sense in senses:
            if isinstance(sense, Sense):
                sense.attributed.add(partial(self._tell_sensed, reference(engine_id, sense.name)))

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Attend as an application asks; refuse a visitor who is not there."""
        mode = changes.get("attention", self.attention)
        known = [each.visitor_ref for each in self._visitors.present]
        if mode not in _MODES and mode not in known:
            raise BadParameter(
                f"attention is {NEAREST}, {LOUDEST} or a visitor_ref of now: {', '.join(known) or 'none'}"
            )
        self._attention.set_mode(mode)
        return changes

    @query
    async def visitors(self) -> VisitorsResult:
        """Return who sends now."""
        present = self._visitors.present
        return VisitorsResult(
            visitor_ref=tuple(each.visitor_ref for each in present),
            devices=tuple(_devices(each) for each in present),
            consent=tuple(_consent(each) for each in present),
            attended=self._attention.attended,
        )

    @event
    def visitor_changed(self, visitor_ref: str, devices: str, consent: str) -> None:
        """A visitor has come or left, sends something else, or consents to something else.

        Args:
            visitor_ref: of the visitor
            devices: what it sends, such as `microphone camera`; empty when it has left
            consent: what it consents to, such as `live recognition`
        """

    @event
    def attended(self, visitor_ref: str) -> None:
        """The visitor whom the senses follow from now on; empty for none."""

    @event
    def sensed(self, visitor_ref: str, component_ref: str, event_type: str) -> None:
        """The next event of this type of this sense tells of this visitor.

        Args:
            visitor_ref: of the visitor
            component_ref: the sense
            event_type: its event
        """

    def _tell_sensed(self, component_ref: str, event_type: str, visitor_ref: str) -> None:
        # What ends with a withdrawal, as a sound, names no visitor.
        if self._visitors.holds(visitor_ref, _RECOGNITION):
            self.sensed(visitor_ref, component_ref, event_type)

    def _on_changed(self, visitor: Visitor) -> None:
        now = _devices(visitor), _consent(visitor)
        if now == self._told.get(visitor.visitor_ref):
            return
        if visitor.is_present:
            self._told[visitor.visitor_ref] = now
        else:
            self._told.pop(visitor.visitor_ref, None)
        self.visitor_changed(visitor.visitor_ref, *now)


def _devices(visitor: Visitor) -> str:
    names = {"microphone": visitor.sends("audio"), "camera": visitor.sends("video")}
    return " ".join(name for name, sent in names.items() if sent)


def _consent(visitor: Visitor) -> str:
    return " ".join(sorted(visitor.consent.purposes)) if visitor.is_present else ""
