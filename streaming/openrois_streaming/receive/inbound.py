"""Selection of the packets of the received source, with wraps and RTX undone. Pure."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from openrois_streaming.receive.reception import SourceReception
from openrois_streaming.receive.remote_time import CaptureTime, CaptureTimes, RemoteClock

RTX = "video/rtx"

SILENCE = 0.1
"""Seconds of silence of a source after which another one of the same kind replaces it."""


class Arrived(NamedTuple):
    """RTP packet, as far as a receiver needs it; `send_time` is abs-send-time as it stands in the packet."""

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
    """Sender report: `ntp` (64 bits) and `timestamp` are one moment; `moment` is `ntp` in seconds since 1970."""

    ssrc: int
    ntp: int
    moment: float
    timestamp: int


class Codec(NamedTuple):
    """Negotiated payload type. For RTX, `repairs` is the payload type of the repeated packets."""

    payload_type: int
    mime_type: str
    clock_rate: int
    repairs: int | None


class Negotiated(NamedTuple):
    """Negotiated parameters of the other end; `sources` are announced SSRCs, `repairs` maps those of RTX to them."""

    codecs: Sequence[Codec]
    sources: Sequence[int]
    repairs: dict[int, int]


class MediaPacket(NamedTuple):
    """RTP packet of the received source; numbers are unwrapped, and RTX is removed."""

    mime_type: str
    sequence: int
    timestamp: int
    marker: bool
    payload: bytes


class Source:
    """Received source (SSRC)."""

    def __init__(self, ssrc: int, clock_rate: int, remote: RemoteClock) -> None:
        self.ssrc = ssrc
        self.last_packet_at = 0.0
        self.sequence = Unwrapped(16)
        self.timestamp = Unwrapped(32)
        self.reception = SourceReception(clock_rate)
        self.capture = CaptureTimes(clock_rate, remote)


class Inbound:
    """Inbound packets of one source at a time, in one of the codecs of `decodable`.

    `on_change` is called when another source replaces it, `on_unused` with each SSRC that was not announced and is not
    received.
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
        """Apply the parameters of an answer."""
        usable = {*self._decodable, RTX}
        self._codecs = {each.payload_type: each for each in parameters.codecs if each.mime_type in usable}
        self._announced = frozenset((*parameters.sources, *parameters.repairs))
        self._repairs = parameters.repairs

    def knows(self, packet: Arrived) -> bool:
        """Tell whether the payload type of a packet was negotiated."""
        return packet.payload_type in self._codecs

    def receive_packet(self, packet: Arrived, now: float) -> MediaPacket | None:
        """Count a packet; returns it as the source sent it, None if it is not received."""
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
        """Apply a sender report."""
        source = self.source
        if source is not None and report.ssrc == source.ssrc:
            source.reception.reported(report.ntp, now)
            source.capture.reported(report.moment, source.timestamp.nearest(report.timestamp), now)

    def captured(self, timestamp: int, now: float) -> CaptureTime:
        """Return the capture time of a timestamp, `now` at the latest."""
        return CaptureTime(now, None) if self.source is None else self.source.capture.captured(timestamp, now)

    def _repaired(self, packet: Arrived, codec: Codec) -> MediaPacket | None:
        """Return the packet in a retransmission (RFC 4588 section 4)."""
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
        """Return the received source, if the packet belongs to it."""
        source = self.source
        if source is None or source.ssrc != packet.ssrc:
            if source is not None and now - source.last_packet_at < SILENCE:
                self._report_unused(packet.ssrc)
                return None
            if source is not None:
                self._report_unused(source.ssrc)
                self._on_change()
            source = self.source = Source(packet.ssrc, codec.clock_rate, self._remote)
        source.last_packet_at = now
        return source

    def _report_unused(self, ssrc: int) -> None:
        if ssrc not in self._announced:
            self._on_unused(ssrc)


class Unwrapped:
    """Counter of `bits` bits, as RTP's sequence numbers and timestamps (RFC 3550 section 5.1), without wraps."""

    __slots__ = ("_modulus", "_newest")

    def __init__(self, bits: int) -> None:
        self._modulus = 1 << bits
        self._newest: int | None = None

    def __call__(self, value: int) -> int:
        """Return `value` without wraps: of all numbers with these low bits, the one nearest to the newest so far."""
        number = self.nearest(value)
        if self._newest is None or number > self._newest:
            self._newest = number
        return number

    def nearest(self, value: int) -> int:
        """Return `value` without wraps, and leave the counter as it is."""
        if self._newest is None:
            # Far enough from 0 that earlier numbers stay positive.
            return self._modulus + value
        distance = (value - self._newest) % self._modulus
        return self._newest + distance - (self._modulus if distance >= self._modulus // 2 else 0)
