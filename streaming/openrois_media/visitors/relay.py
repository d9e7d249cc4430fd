"""Relays: what visitors send, published to the listeners that they consent to.

Sound and pictures are decoded once and encoded once for all listeners with the same purposes: only so does each block
and picture pass the gate, each listener gets a codec and a size that suit its path, and a listener that asks for a key
frame asks the encoder here, never the visitor.
"""

from dataclasses import dataclass
from typing import Final

from openrois_signaling.messages import MediaKind
from openrois_streaming.clock import MediaClock
from openrois_streaming.publish.encoder_limit import EncoderLimit
from openrois_streaming.publish.publisher import AudioPublisher, Publishing, VideoPublisher

from openrois.contract import Client
from openrois.errors import BadParameter, OutOfResources, Unsupported
from openrois.types.codes import Purpose
from openrois_media.visitors.visitor import DEVICES, Visitor

__all__ = ["MAX_RELAYED_CAMERAS", "MAX_RELAYED_MICROPHONES", "Relays"]

MAX_RELAYED_CAMERAS: Final = 4
"""Cameras of visitors that are encoded for listeners at a time; the same camera for other purposes is another one."""

MAX_RELAYED_MICROPHONES: Final = 16
"""Microphones likewise: those of eight visitors for two sets of purposes."""

_MOST: Final[dict[MediaKind, int]] = {"video": MAX_RELAYED_CAMERAS, "audio": MAX_RELAYED_MICROPHONES}


@dataclass(frozen=True, slots=True)
class _Relay:
    """What is relayed, and what for."""

    visitor: Visitor
    kind: MediaKind
    purposes: frozenset[Purpose]


class Relays:
    """Streams of listeners, with a publisher for each visitor's device and set of purposes that is listened to.

    Args:
        clock: the media clock.
    """

    def __init__(self, clock: MediaClock) -> None:
        self._clock = clock
        self._streams: dict[str, tuple[Client, _Relay]] = {}
        self._publishers: dict[_Relay, Publishing] = {}

    def __len__(self) -> int:
        return len(self._streams)

    def publisher(self, visitor: Visitor, kind: MediaKind, purposes: frozenset[Purpose]) -> Publishing:
        """Return what publishes a visitor's device for these purposes.

        Raises:
            BadParameter: no purpose is stated.
            Unsupported: the visitor sends no such device, or does not consent.
            OutOfResources: as many devices of the kind are relayed as may be.
        """
        if not purposes:
            raise BadParameter("a listener states what it uses media for: set purposes in transport_parameters")
        if not visitor.sends(kind):
            raise Unsupported(f"{visitor.visitor_ref} sends no {DEVICES[kind]}")
        if refused := sorted(purposes - visitor.consent.purposes):
            raise Unsupported(f"{visitor.visitor_ref} does not consent to {', '.join(refused)}")
        relay = _Relay(visitor, kind, purposes)
        used = {each for _, each in self._streams.values()}
        if sum(each.kind == kind for each in used - {relay}) >= _MOST[kind]:
            raise OutOfResources(
                f"{_MOST[kind]} {DEVICES[kind]}s of visitors are relayed, which is the limit: disconnect another one"
            )
        return self._publishers.get(relay) or self._make(relay)

    def add_stream(
        self,
        client: Client,
        stream_id: str,
        visitor: Visitor,
        purposes: frozenset[Purpose],
        publisher: Publishing,
    ) -> None:
        """Note a stream of a listener, and what publishes it."""
        relay = _Relay(visitor, publisher.kind, purposes)
        self._streams[stream_id] = client, relay
        self._publishers[relay] = publisher

    def end_stream(self, stream_id: str) -> None:
        """Forget a stream that has ended; another one is ignored."""
        _, relay = self._streams.pop(stream_id, (None, None))
        if relay is not None and all(relay != each for _, each in self._streams.values()):
            self._publishers.pop(relay, None)

    def lost_with(self, visitor: Visitor, withdrawn: frozenset[Purpose]) -> list[tuple[Client, str]]:
        """Return the streams that rest on a consent which is withdrawn, and their listeners."""
        return [
            (client, stream_id)
            for stream_id, (client, relay) in self._streams.items()
            if relay.visitor is visitor and relay.purposes & withdrawn
        ]

    def _make(self, relay: _Relay) -> Publishing:
        source = relay.visitor.source(relay.kind, relay.purposes)
        name = f"{DEVICES[relay.kind]} of a visitor for {', '.join(sorted(relay.purposes))}"
        if relay.kind == "audio":
            return AudioPublisher(source, clock=self._clock, name=name)
        return VideoPublisher(source, clock=self._clock, encoders=EncoderLimit(1), name=name)
