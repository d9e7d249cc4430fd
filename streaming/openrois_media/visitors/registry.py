"""Visitors of one body: one for each application that sends, and a limit on their number."""

from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from typing import Final

from openrois_signaling.messages import MediaKind
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.source.uplink_sink import UplinkSink

from openrois.aio.listeners import Listeners
from openrois.contract import Client
from openrois.errors import OutOfResources, Unsupported
from openrois.types.codes import Purpose
from openrois.types.references import new_id
from openrois_media.visitors.consent import UNSTATED
from openrois_media.visitors.visitor import DEVICES, ConsentedSink, Visitor

__all__ = ["KEPT", "MAX_VISITORS", "VisitorRegistry", "VisitorUplink"]

MAX_VISITORS: Final = 8
"""Applications that send to one body at a time."""

KEPT: Final = frozenset({Purpose.RECOGNITION, Purpose.RECORDING})
"""What a visitor consents to of whom something that is recognised may be kept."""


@dataclass(frozen=True, slots=True, eq=False)
class VisitorUplink:
    """Uplink of a streaming component to which every visitor may send, each its own; made by `VisitorRegistry`."""

    kind: MediaKind
    visitors: "VisitorRegistry" = field(repr=False)


class VisitorRegistry:
    """Visitors of a body, by the applications that they are.

    Microphone and camera of one application are of one visitor, whose `visitor_ref` stays the same until the
    application has left. Its consent ends with the last stream that it sends.

    Args:
        engine_id: part of every visitor_ref.
        clock: the clock of the capture times; this machine's unless given.

    Attributes:
        cameras: uplink of a component that takes the camera of every visitor.
        microphones: uplink of a component that takes the microphone of every visitor.
        changed: called with a visitor that has come or left, sends something else or consents to something else.
        withdrawn: called with a visitor and what it does not consent to any more; all of it when the visitor has left.
        refused: how often an application was refused because as many visitors send as may.
    """

    def __init__(self, engine_id: str, clock: MediaClock | None = None) -> None:
        self.cameras, self.microphones = VisitorUplink("video", self), VisitorUplink("audio", self)
        self.changed: Listeners[Visitor] = Listeners()
        self.withdrawn: Listeners[Visitor, frozenset[Purpose]] = Listeners()
        self.refused = 0
        self._engine_id = engine_id
        self._clock = clock or SystemClock()
        self._visitors: dict[Client, Visitor] = {}
        """Every application that has sent and has not left since, in the order of their first streams."""

    @property
    def present(self) -> tuple[Visitor, ...]:
        """Visitors that send now, the first that came first."""
        return tuple(visitor for visitor in self._visitors.values() if visitor.is_present)

    def find(self, visitor_ref: str) -> Visitor:
        """Return the visitor of that name.

        Raises:
            Unsupported: no visitor that sends has it.
        """
        for visitor in self.present:
            if visitor.visitor_ref == visitor_ref:
                return visitor
        raise Unsupported(f"there is no visitor {visitor_ref[:200]!r}: it has left, or never came")

    def admits(self, sender: str, purposes: AbstractSet[Purpose], captured_at: float) -> bool:
        """Tell whether an item of this sender may be used now; of media of the body itself, which has no sender, all.

        This is the gate that every block, picture and event passes.
        """
        visitor = self._named(sender)
        return not sender or (visitor is not None and visitor.consent.admits(purposes, captured_at))

    def holds(self, sender: str, purposes: AbstractSet[Purpose]) -> bool:
        """Tell whether this sender consents to all of these purposes now; the body itself always does."""
        visitor = self._named(sender)
        return not sender or (visitor is not None and visitor.consent.holds(purposes))

    def may_keep(self, sender: str) -> bool:
        """Tell whether what is recognised of this sender may be kept; of one that states nothing it may, as ever."""
        visitor = self._named(sender)
        return not sender or (visitor is not None and (not visitor.states_consent or visitor.consent.holds(KEPT)))

    def states_consent(self, sender: str) -> bool:
        """Tell whether what is kept of this sender rests on a consent that it has stated, and ends with that."""
        visitor = self._named(sender)
        return visitor is not None and visitor.states_consent

    def sink(self, client: Client, uplink: UplinkSink | VisitorUplink, kind: MediaKind) -> ConsentedSink:
        """Return the sink of a stream that an application is about to send.

        Raises:
            OutOfResources: as many visitors send as may, or this one sends such a device already.
        """
        visitor = self._visitors.get(client) or Visitor(
            f"urn:x-rois:def:visitor:OpenRoIS::{new_id(self._engine_id)}", self._clock
        )
        present = self.present
        if visitor not in present and len(present) >= MAX_VISITORS:
            self.refused += 1
            raise OutOfResources(
                f"{MAX_VISITORS} visitors send to {self._engine_id}, which is the limit: wait until one has left"
            )
        if not isinstance(uplink, VisitorUplink):
            return ConsentedSink(visitor, uplink, Purpose.LIVE)
        if visitor.sends(kind):
            raise OutOfResources(
                f"this application sends a {DEVICES[kind]} to {self._engine_id} already: disconnect that stream first"
            )
        return ConsentedSink(visitor, visitor.inlet(kind), None)

    def add_stream(
        self, client: Client, stream_id: str, sink: ConsentedSink, consent: frozenset[Purpose] | None
    ) -> None:
        """Note a stream whose sink was made here, and what its sender consents to; None where it states nothing."""
        visitor = sink.visitor
        if client not in self._visitors:
            self._visitors[client] = visitor
            visitor.withdrawn.add(lambda purposes: self.withdrawn.notify_all(visitor, purposes))
        is_first = not visitor.is_present
        visitor.add(stream_id, sink)
        if consent is not None:
            visitor.states_consent = True
            visitor.state(consent)
        elif is_first:
            visitor.state(UNSTATED)
        self.changed.notify_all(visitor)

    def set_consent(self, client: Client, stream_id: str, consent: frozenset[Purpose]) -> str:
        """State all that an application consents to from now on, by a stream that it sends; return its visitor_ref.

        Raises:
            Unsupported: it sends no such stream.
        """
        visitor = self._visitors.get(client)
        if visitor is None or not visitor.has(stream_id):
            raise Unsupported("consent is stated for what is sent, and this stream is received: name one that is sent")
        visitor.states_consent = True
        visitor.state(consent)
        self.changed.notify_all(visitor)
        return visitor.visitor_ref

    def end_stream(self, client: Client, stream_id: str) -> None:
        """Forget a stream that has ended; one that is received is ignored."""
        visitor = self._visitors.get(client)
        if visitor is not None and visitor.remove(stream_id):
            if not visitor.is_present:
                visitor.leave()
            self.changed.notify_all(visitor)

    def forget_client(self, client: Client) -> None:
        """Forget an application that has left."""
        visitor = self._visitors.pop(client, None)
        if visitor is not None:
            visitor.leave()
            self.changed.notify_all(visitor)

    def _named(self, visitor_ref: str) -> Visitor | None:
        return next((each for each in self._visitors.values() if each.visitor_ref == visitor_ref), None)
