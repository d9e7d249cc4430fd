"""An m-section of a peer connection, and the way of a stream over it."""

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import replace
from typing import Final

from aiortc import RTCPeerConnection, RTCRtpSender, RTCRtpTransceiver
from openrois_signaling.messages import Direction, MediaKind, SenderClock

from openrois_streaming.aiortc_internals.connection import negotiated_codec
from openrois_streaming.aiortc_internals.sending import DtlsWire, take_over
from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import AUDIO_CLOCK_RATE, VIDEO_CLOCK_RATE, EncodedFrame
from openrois_streaming.liveness import Flow, Verdict
from openrois_streaming.peer.arrival import both
from openrois_streaming.peer.downlink import Downlink
from openrois_streaming.peer.sdp import Answered
from openrois_streaming.peer.stream import Stream
from openrois_streaming.peer.uplink import Reception, Uplink
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.send.outlet import Outlet
from openrois_streaming.send.sender import RtpSender
from openrois_streaming.stats import StreamStats
from openrois_streaming.tasks import OwnedTasks

RTX: Final = "video/rtx"
_CLOCK_RATES: Final = {"video": VIDEO_CLOCK_RATE, "audio": AUDIO_CLOCK_RATE}

OPPOSITE: Final[dict[Answered, Answered]] = {
    "recvonly": "sendonly",
    "sendonly": "recvonly",
    "sendrecv": "sendrecv",
    "inactive": "inactive",
}
"""A direction as the other end sees it."""

_RECEIVING: Final = frozenset({"recvonly", "sendrecv"})
_SENDING: Final = frozenset({"sendonly", "sendrecv"})


class StreamPath:
    """A stream on its way over one m-section."""

    __slots__ = (
        "_before",
        "_clock",
        "_downlink",
        "_uplink",
        "flow",
        "generation",
        "report",
        "section",
        "stream",
        "up",
    )

    def __init__(self, stream: Stream, section: "Section", tasks: OwnedTasks, clock: MediaClock) -> None:
        self.stream = stream
        self.section = section
        self.flow = Flow(stream.kind, section.highest_sequence)
        self.generation: int | None = None
        """The first offer that lists it; None before that."""
        self.report: ReceiverReport | None = None
        """The viewer's newest report."""
        self.up = False
        """Whether its section is negotiated and the peer connection is there."""
        self._before = replace(section.sender.figures)
        self._clock = clock
        self._downlink: Downlink | None = None
        if stream.publisher is not None:
            self._downlink = Downlink(stream, section.sender, tasks, clock, section.round_trip)
        self._uplink: Uplink | None = None
        if stream.intake is not None:
            assert section.reception is not None, "a section of an uplink receives"
            self._uplink = Uplink(section.reception, stream.intake, clock)

    def listed_by(self, generation: int) -> bool:
        """Whether offer number `generation`, or an earlier one, lists it."""
        return self.generation is not None and self.generation <= generation

    @property
    def declined(self) -> bool:
        """Whether the application has answered that it wants nothing of it."""
        return self.section.answered == "inactive"

    def follow(self) -> None:
        """Send and receive, or do not, as the stream's phase, the answer and the media path have it."""
        wanted = self.up and self.stream.is_open
        sends = wanted and self.section.answered in _RECEIVING
        if not sends:
            self._stop_sending()
        elif self._downlink is not None and not self._downlink.is_open:
            assert self.section.codec is not None, "a leg is up only when its section is negotiated"
            self.flow.opened(self._clock.now())
            self._downlink.open(self.section.codec)
        if self._uplink is not None:
            self._uplink.follow(there=self.up and self.section.answered in _SENDING, wanted=wanted)

    def prepare(self) -> None:
        """What is about to be sent may begin to be made: the answer is there, and the media path will be."""
        wanted = self.stream.is_open and self.section.answered in _RECEIVING
        if wanted and self._downlink is not None and self.section.codec is not None:
            self._downlink.prepare(self.section.codec)

    def judge(self, now: float, seen: float) -> Verdict:
        """Whether media reaches the other end in each direction that was agreed on; `seen` as for `Flow.judge`."""
        verdicts = []
        if self.section.answered in _RECEIVING:
            verdicts.append(self.flow.judge(now, seen, self._pause))
        if self._uplink is not None and self.section.answered in _SENDING:
            verdicts.append(self._uplink.judge(now))
        return both(verdicts)

    @property
    def _pause(self) -> float:
        return 0.0 if self._downlink is None else self._downlink.pause

    def close(self) -> None:
        """Stop sending and receiving. The rendition is left at once, so that its encoder can rest."""
        self._stop_sending()
        if self._uplink is not None:
            self._uplink.close()

    def capture_clock(self) -> SenderClock | None:
        """The capture time of what is sent, by its RTP timestamps; None while nothing can be sent here."""
        ssrc = self.section.sender.ssrc
        if ssrc is None or self._downlink is None or not self._downlink.is_open:
            return None
        # A whole millisecond of the time of day, and the timestamp of that moment, so that nothing is lost by rounding.
        wall = int(self._clock.wall() * 1000)
        moment = self._clock.now() - (self._clock.wall() - wall / 1000)
        rate = _CLOCK_RATES[self.stream.kind]
        origin = self.section.sender.timestamp(round(moment * rate))
        return SenderClock(mid=self.section.mid, ssrc=ssrc, clock_rate=rate, rtp_origin=origin, wall=wall)

    def tick(self, now: float) -> None:
        """Decide anew what the viewer is sent."""
        if self._downlink is not None:
            self._downlink.tick(now)

    @property
    def refused(self) -> str:
        """Why nothing can be sent; empty where it can."""
        return "" if self._downlink is None else self._downlink.refused

    def _stop_sending(self) -> None:
        if self._downlink is not None:
            self._downlink.close()
        self.flow.closed()

    def _repair(self) -> None:
        if self._downlink is not None:
            self._downlink.repair()

    def key_frame_wanted(self) -> None:
        """The viewer cannot decode and asks for a key frame."""
        self.stream.counters.key_frame_requests += 1
        self._repair()

    def left_out(self, frames: int, *, repair: bool) -> None:
        """The sender left out `frames`, and needs a key frame if `repair`."""
        self.stream.counters.frames_dropped += frames
        if repair:
            self._repair()

    def sent(self, frame: EncodedFrame) -> None:
        """The sender took `frame`."""
        self.flow.left(self._clock.now(), self._pause)
        self.stream.counters.sent(frame)
        if self._downlink is not None:
            self._downlink.sent(frame)

    def reported(self, report: ReceiverReport) -> None:
        """The viewer reported on what it received."""
        self.flow.reported(report.highest_sequence, self._clock.now())
        self.report = report
        if self._downlink is not None:
            self._downlink.reported(report)

    def estimated(self, bitrate: int) -> None:
        """The viewer said what its path carries, in bit/s."""
        if self._downlink is not None:
            self._downlink.estimated(bitrate)

    async def stats(self) -> StreamStats:
        """The figures of the stream, with what the viewer says about this way."""
        counters, report = self.stream.counters, self.report
        sent, before = self.section.sender.figures, self._before
        return StreamStats(
            stream_id=self.stream.stream_id,
            component_ref=self.stream.component_ref,
            kind=self.stream.kind,
            status=self.stream.status,
            codec=self.section.codec,
            frames_sent=counters.frames_sent,
            frames_dropped=counters.frames_dropped,
            key_frames=counters.key_frames,
            bytes_sent=counters.bytes_sent,
            key_frame_requests=counters.key_frame_requests,
            packets_sent=sent.packets - before.packets,
            packets_retransmitted=sent.retransmitted - before.retransmitted,
            retransmissions_refused=sent.refused - before.refused,
            frames_received=0 if self._uplink is None else self._uplink.frames,
            path_bitrate=self.section.path_bitrate,
            round_trip_time=None if report is None else report.round_trip_time,
            packets_lost=None if report is None else report.packets_lost,
            fraction_lost=None if report is None else report.fraction_lost,
            jitter=None if report is None else report.jitter / _CLOCK_RATES[self.stream.kind],
            playout_delay=self.stream.playout_delay,
            adaptation=None if self._downlink is None else self._downlink.figures(),
            reception=None if self._uplink is None else self._uplink.figures,
        )


class Section:
    """One m-section. Its transceiver, its sender and its codec stay as long as the peer connection; streams change.

    The payload type of a sender is fixed and aiortc cannot take a section out of a description, so a section is only
    ever taken over by a stream of the same kind and direction that may be sent in the same codec.

    `outlet` and `wire` are shared by all sections of a viewer.
    """

    def __init__(
        self,
        connection: RTCPeerConnection,
        kind: MediaKind,
        codecs: Sequence[str],
        outlet: Outlet,
        wire: DtlsWire,
        direction: Direction = "recvonly",
    ) -> None:
        self.kind: MediaKind = kind
        self.direction: Direction = direction
        """Of its streams, seen from the application."""
        self.answered: Answered = "inactive"
        """What the application does in it as it last said."""
        self.reception: Reception | None = None
        """What receives, where the application sends."""
        self.leg: StreamPath | None = None
        self.codec: str | None = None
        """The negotiated media type; None before the first answer."""
        self.highest_sequence: int | None = None
        """The newest packet the viewer has reported; None before its first report."""
        self.path_bitrate: int | None = None
        """What the viewer said that its path carries (bit/s), of everything it is sent; None before its first word."""
        self.round_trip: Callable[[], Awaitable[float | None]] = _unknown
        """Seconds that a packet takes there and back now; None if unknown."""
        self.sender = RtpSender(kind, self, outlet)
        self.transceiver: RTCRtpTransceiver = connection.addTransceiver(kind, direction=OPPOSITE[direction])
        self._prefer(codecs)
        take_over(self.transceiver.sender, self.sender, wire)

    @property
    def mid(self) -> str:
        """Its name in the descriptions, once one was made."""
        mid = self.transceiver.mid
        assert mid is not None, "a section has its name from the first description on"
        return mid

    def suits(self, stream: Stream) -> bool:
        """Whether it is idle and `stream` can take it over."""
        alike = self.kind == stream.kind and self.direction == stream.direction
        return self.leg is None and alike and self.codec in stream.codecs

    def describe(self) -> None:
        """Offer what its stream wants; nothing if it has none."""
        self.transceiver.direction = "inactive" if self.leg is None else OPPOSITE[self.direction]

    def negotiated(self, answered: Answered) -> None:
        """An answer was applied: from now on only the codec it chose is offered.

        A sender that has not started yet would otherwise start with the first codec of a later offer.
        """
        self.answered = answered
        if self.codec is None:
            codec = negotiated_codec(self.transceiver)
            assert codec is not None, "an answer without a common codec is refused"
            self.codec = codec
            self._prefer([codec])

    def sent(self, frame: EncodedFrame) -> None:
        """The sender took `frame`."""
        if self.leg is not None:
            self.leg.sent(frame)

    def left_out(self, frames: int, *, repair: bool) -> None:
        """The sender left out `frames`; what follows is of no use without a key frame if `repair`."""
        if self.leg is not None:
            self.leg.left_out(frames, repair=repair)

    def reported(self, report: ReceiverReport) -> None:
        """The viewer reported on what it received."""
        self.highest_sequence = report.highest_sequence
        if self.leg is not None:
            self.leg.reported(report)

    def estimated(self, bitrate: int) -> None:
        """The viewer said what its path carries, in bit/s."""
        self.path_bitrate = bitrate
        if self.leg is not None:
            self.leg.estimated(bitrate)

    def key_frame_wanted(self) -> None:
        """The viewer cannot decode."""
        if self.leg is not None:
            self.leg.key_frame_wanted()

    def _prefer(self, codecs: Sequence[str]) -> None:
        known = RTCRtpSender.getCapabilities(self.kind).codecs
        chosen = [capability for codec in (*codecs, RTX) for capability in known if capability.mimeType == codec]
        self.transceiver.setCodecPreferences(chosen)


async def _unknown() -> None:
    """The round trip where there is no connection."""
