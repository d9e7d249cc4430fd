"""Which of the packets that arrive are of the source that is received, with their wraps and their RTX undone. Pure."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from openrois_streaming.receive.reception import SourceReception
from openrois_streaming.receive.remote_time import CaptureTimes, RemoteClock
from openrois_streaming.receive.sequence import Unwrapped

RTX = "video/rtx"

SILENCE = 0.1
"""Seconds: another source of the same kind is listened to when the one before has been silent for so long."""


class Arrived(NamedTuple):
    """An RTP packet, as far as a receiver needs it; `send_time` is abs-send-time as it stands in the packet."""

    payload_type: int
    sequence: int
    timestamp: int
    marker: bool
    ssrc: int
    payload: bytes
    send_time: int | None
    size: int
    """Bytes of payload and padding."""


class SenderReport(NamedTuple):
    """What a sender says: `ntp` (64 bits) and `timestamp` are one moment; `moment` is `ntp` in seconds since 1970."""

    ssrc: int
    ntp: int
    moment: float
    timestamp: int


class Codec(NamedTuple):
    """A payload type that was negotiated. For RTX, `repairs` is the payload type of what it repeats."""

    payload_type: int
    mime_type: str
    clock_rate: int
    repairs: int | None


class Negotiated(NamedTuple):
    """What the other end will send; `sources` and `repairs` are announced SSRCs, the latter by those that repeat."""

    codecs: Sequence[Codec]
    sources: Sequence[int]
    repairs: dict[int, int]


class MediaPacket(NamedTuple):
    """An RTP packet of the source that is received; numbers are unwrapped, and RTX is taken off."""

    mime_type: str
    sequence: int
    timestamp: int
    marker: bool
    payload: bytes


class Source:
    """One SSRC, for as long as it is received."""

    def __init__(self, ssrc: int, clock_rate: int, remote: RemoteClock) -> None:
        self.ssrc = ssrc
        self.heard_at = 0.0
        self.sequence = Unwrapped(16)
        self.timestamp = Unwrapped(32)
        self.reception = SourceReception(clock_rate)
        self.capture = CaptureTimes(clock_rate, remote)


class Inbound:
    """Receives one source at a time, in one of the codecs of `decodable`.

    `on_change` is called when another source takes its place, `on_unused` with each SSRC that was not announced and is
    of no use.
    """

    def __init__(
        self,
        decodable: frozenset[str],
        remote: RemoteClock,
        on_change: Callable[[], None],
        on_unused: Callable[[int], None],
    ) -> None:
        self.source: Source | None = None
        self._decodable = decodable
        self._remote = remote
        self._on_change, self._on_unused = on_change, on_unused
        self._codecs: dict[int, Codec] = {}
        self._announced: frozenset[int] = frozenset()
        self._repairs: dict[int, int] = {}

    def negotiated(self, parameters: Negotiated) -> None:
        """An answer says what comes."""
        usable = {*self._decodable, RTX}
        self._codecs = {each.payload_type: each for each in parameters.codecs if each.mime_type in usable}
        self._announced = frozenset((*parameters.sources, *parameters.repairs))
        self._repairs = parameters.repairs

    def knows(self, packet: Arrived) -> bool:
        """Whether its payload type was negotiated."""
        return packet.payload_type in self._codecs

    def take(self, packet: Arrived, now: float) -> MediaPacket | None:
        """Count a packet; returns it as the source sent it, None if it is of no use."""
        codec = self._codecs.get(packet.payload_type)
        if codec is None:
            return None
        if codec.mime_type == RTX:
            return self._repaired(packet, codec)
        source = self._source_of(packet, codec, now)
        if source is None:
            return None
        sequence, timestamp = source.sequence(packet.sequence), source.timestamp(packet.timestamp)
        source.reception.add(sequence, timestamp, now)
        source.capture.arrived(timestamp, now)
        return MediaPacket(codec.mime_type, sequence, timestamp, packet.marker, packet.payload)

    def reported(self, report: SenderReport, now: float) -> None:
        """A sender report came."""
        source = self.source
        if source is not None and report.ssrc == source.ssrc:
            source.reception.reported(report.ntp, now)
            source.capture.reported(report.moment, source.timestamp.nearest(report.timestamp), now)

    def captured_at(self, timestamp: int, now: float) -> float:
        """When what has this timestamp was captured, `now` at the latest."""
        return now if self.source is None else self.source.capture.captured_at(timestamp, now)

    def _repaired(self, packet: Arrived, codec: Codec) -> MediaPacket | None:
        """What was sent again (RFC 4588 section 4)."""
        source = self.source
        original = None if codec.repairs is None else self._codecs.get(codec.repairs)
        if source is None or original is None or original.mime_type == RTX or len(packet.payload) < 2:
            return None
        if self._repairs.get(packet.ssrc, source.ssrc) != source.ssrc:
            return None
        sequence = source.sequence.nearest(int.from_bytes(packet.payload[:2], "big"))
        timestamp = source.timestamp.nearest(packet.timestamp)
        return MediaPacket(original.mime_type, sequence, timestamp, packet.marker, packet.payload[2:])

    def _source_of(self, packet: Arrived, codec: Codec, now: float) -> Source | None:
        """The source that is received, if the packet is of it."""
        source = self.source
        if source is None or source.ssrc != packet.ssrc:
            if source is not None and now - source.heard_at < SILENCE:
                self._forget(packet.ssrc)
                return None
            if source is not None:
                self._forget(source.ssrc)
                self._on_change()
            source = self.source = Source(packet.ssrc, codec.clock_rate, self._remote)
        source.heard_at = now
        return source

    def _forget(self, ssrc: int) -> None:
        if ssrc not in self._announced:
            self._on_unused(ssrc)
