"""M-section of a peer connection, and the path of a stream over it."""

from collections.abc import Awaitable, Callable, Sequence
from dataclasses import replace
from typing import Final

from aiortc import RTCPeerConnection, RTCRtpSender, RTCRtpTransceiver
from openrois_signaling.messages import Direction, MediaKind, SenderClock

from openrois_streaming.aiortc_internals.connection import negotiated_codec
from openrois_streaming.aiortc_internals.sending import DtlsWire, take_over
from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import AUDIO_CLOCK_RATE, VIDEO_CLOCK_RATE, EncodedFrame
from openrois_streaming.liveness import Flow, Verdict, both
from openrois_streaming.peer.downlink import Downlink
from openrois_streaming.peer.sdp import Answered
from openrois_streaming.peer.stream import Stream
from openrois_streaming.peer.uplink import Reception, Uplink
from openrois_streaming.rtp.reports import ReceiverReport
from openrois_streaming.send.pacer import Outlet
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
"""Direction as seen from the other end."""

_RECEIVING: Final = frozenset({"recvonly", "sendrecv"})
_SENDING: Final = frozenset({"sendonly", "sendrecv"})


class StreamPath:
    """Path of a stream over one m-section."""

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
        """Generation of the first offer that lists the path; None before that."""
        self.report: ReceiverReport | None = None
        """The viewer's newest report; None before the first."""
        self.up = False
        """Whether its section is negotiated and the peer connection established."""
        self._before = replace(section.sender.figures)
        self._clock = clock
        self._downlink: Downlink | None = None
        if stream.publisher is not None:
            self._downlink = Downlink(stream, section.sender, tasks, clock, section.round_trip)
        self._uplink: Uplink | None = None
        if stream.uplink_selector is not None:
            assert section.reception is not None, "a section of an uplink receives"
            self._uplink = Uplink(section.reception, stream.uplink_selector, clock)

    def listed_by(self, generation: int) -> bool:
        """Tell whether offer number `generation`, or an earlier one, lists the path."""
        return self.generation is not None and self.generation <= generation

    @property
    def declined(self) -> bool:
        """Whether the application has declined the section."""
        return self.section.answered == "inactive"

    def follow(self) -> None:
        """Start or stop sending and receiving by the stream's phase, the answer and the media path."""
        # A suspended stream stops here, without negotiation: its track lives on, so the viewer keeps the last picture.
        wanted = self.up and self.stream.is_open
        sends = wanted and self.section.answered in _RECEIVING
        if not sends:
            self._stop_sending()
        elif self._downlink is not None and not self._downlink.is_open:
            assert self.section.codec is not None, "a path is up only when its section is negotiated"
            self.flow.opened(self._clock.now())
            self._downlink.open(self.section.codec)
        if self._uplink is not None:
            self._uplink.follow(there=self.up and self.section.answered in _SENDING, wanted=wanted)

    def prepare(self) -> None:
        """Run the encoder ahead: the answer is applied, and the media path is about to be established."""
        wanted = self.stream.is_open and self.section.answered in _RECEIVING
        if wanted and self._downlink is not None and self.section.codec is not None:
            self._downlink.prepare(self.section.codec)

    def judge(self, now: float, seen: float) -> Verdict:
        """Judge whether media flows in each agreed direction; `seen` as for `Flow.judge`."""
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
        """Stop sending and receiving. The rendition is left at once, so that its encoder can stop."""
        self._stop_sending()
        if self._uplink is not None:
            self._uplink.close()

    def capture_clock(self) -> SenderClock | None:
        """Return the capture clock of the sent RTP timestamps; None while the path does not send."""
        ssrc = self.section.sender.ssrc
        if ssrc is None or self._downlink is None or not self._downlink.is_open:
            return None
        # A whole millisecond of the time of day, and the timestamp of that moment, so that rounding loses nothing.
        wall = int(self._clock.wall() * 1000)
        moment = self._clock.now() - (self._clock.wall() - wall / 1000)
        rate = _CLOCK_RATES[self.stream.kind]
        origin = self.section.sender.timestamp(round(moment * rate))
        return SenderClock(mid=self.section.mid, ssrc=ssrc, clock_rate=rate, rtp_origin=origin, wall=wall)

    def tick(self, now: float) -> None:
        """Decide anew which rendition the viewer is sent."""
        if self._downlink is not None:
            self._downlink.tick(now)

    @property
    def refused(self) -> str:
        """The reason for which the stream can never be sent; empty if it can."""
        return "" if self._downlink is None else self._downlink.refused

    def _stop_sending(self) -> None:
        if self._downlink is not None:
            self._downlink.close()
        self.flow.closed()

    def _repair(self) -> None:
        if self._downlink is not None:
            self._downlink.repair()

    def key_frame_wanted(self) -> None:
        """Request a key frame: the viewer cannot decode."""
        self.stream.counters.key_frame_requests += 1
        self._repair()

    def left_out(self, frames: int, *, repair: bool) -> None:
        """Count `frames` that the sender dropped; request a key frame if `repair`."""
        self.stream.counters.frames_dropped += frames
        if repair:
            self._repair()

    def sent(self, frame: EncodedFrame) -> None:
        """Note that the sender has sent `frame`."""
        self.flow.left(self._clock.now(), self._pause)
        self.stream.counters.sent(frame)
        if self._downlink is not None:
            self._downlink.sent(frame)

    def reported(self, report: ReceiverReport) -> None:
        """Apply a receiver report of the viewer."""
        self.flow.reported(report.highest_sequence, self._clock.now())
        self.report = report
        if self._downlink is not None:
            self._downlink.reported(report)

    def estimated(self, bitrate: int) -> None:
        """Apply the viewer's estimate of its path, in bit/s."""
        if self._downlink is not None:
            self._downlink.estimated(bitrate)

    async def stats(self) -> StreamStats:
        """Return the figures of the stream, with the viewer's reports on this path."""
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
    """M-section. Its transceiver, sender and codec stay as long as the peer connection; streams change.

    The payload type of a sender is fixed and aiortc cannot remove a section from a description, so a section is reused
    only by a stream of the same kind and direction that may be sent in the same codec.

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
        """Direction of its streams, seen from the application."""
        self.answered: Answered = "inactive"
        """The application's direction by its last answer."""
        self.reception: Reception | None = None
        """The receiver, where the application sends."""
        self.stream_path: StreamPath | None = None
        self.codec: str | None = None
        """The negotiated media type; None before the first answer."""
        self.highest_sequence: int | None = None
        """Newest packet that the viewer has reported; None before its first report."""
        self.path_bitrate: int | None = None
        """Bit/s that the viewer estimates its path to carry, of everything sent; None before its first estimate."""
        self.round_trip: Callable[[], Awaitable[float | None]] = _unknown
        """Measures the round trip in seconds; None if unknown."""
        self.sender = RtpSender(kind, self, outlet)
        self.transceiver: RTCRtpTransceiver = connection.addTransceiver(kind, direction=OPPOSITE[direction])
        self._prefer(codecs)
        take_over(self.transceiver.sender, self.sender, wire)

    @property
    def mid(self) -> str:
        """Name of the section in descriptions, once one was made."""
        mid = self.transceiver.mid
        assert mid is not None, "a section has its name from the first description on"
        return mid

    def suits(self, stream: Stream) -> bool:
        """Tell whether the section is idle and `stream` can use it."""
        alike = self.kind == stream.kind and self.direction == stream.direction
        return self.stream_path is None and alike and self.codec in stream.codecs

    def describe(self) -> None:
        """Offer the direction of its stream; inactive without one."""
        self.transceiver.direction = "inactive" if self.stream_path is None else OPPOSITE[self.direction]

    def negotiated(self, answered: Answered) -> None:
        """Note an applied answer: from now on only its codec is offered.

        A sender that has not started yet would otherwise start with the first codec of a later offer.
        """
        self.answered = answered
        if self.codec is None:
            codec = negotiated_codec(self.transceiver)
            assert codec is not None, "an answer without a common codec is refused"
            self.codec = codec
            self._prefer([codec])

    def sent(self, frame: EncodedFrame) -> None:
        """Note that the sender has sent `frame`."""
        if self.stream_path is not None:
            self.stream_path.sent(frame)

    def left_out(self, frames: int, *, repair: bool) -> None:
        """Count `frames` that the sender dropped; request a key frame if `repair`."""
        if self.stream_path is not None:
            self.stream_path.left_out(frames, repair=repair)

    def reported(self, report: ReceiverReport) -> None:
        """Apply a receiver report of the viewer."""
        self.highest_sequence = report.highest_sequence
        if self.stream_path is not None:
            self.stream_path.reported(report)

    def estimated(self, bitrate: int) -> None:
        """Apply the viewer's estimate of its path, in bit/s."""
        self.path_bitrate = bitrate
        if self.stream_path is not None:
            self.stream_path.estimated(bitrate)

    def key_frame_wanted(self) -> None:
        """Request a key frame: the viewer cannot decode."""
        if self.stream_path is not None:
            self.stream_path.key_frame_wanted()

    def _prefer(self, codecs: Sequence[str]) -> None:
        known = RTCRtpSender.getCapabilities(self.kind).codecs
        chosen = [capability for codec in (*codecs, RTX) for capability in known if capability.mimeType == codec]
        self.transceiver.setCodecPreferences(chosen)


async def _unknown() -> None:
    """Return None: there is no connection to measure."""
