"""An m-section of a peer connection, and the way of a stream over it."""

from collections.abc import Sequence
from typing import Final

from aiortc import RTCPeerConnection, RTCRtpSender, RTCRtpTransceiver
from openrois_signaling.messages import MediaKind

from openrois_streaming.aiortc_seams import ReceiverReport, date_by_capture, negotiated_codec, watch_sender
from openrois_streaming.clock import MediaClock
from openrois_streaming.encoded import AUDIO_CLOCK_RATE, VIDEO_CLOCK_RATE, EncodedFrame
from openrois_streaming.feed import SharedRendition, feed
from openrois_streaming.keyframes import KeyFrameCause
from openrois_streaming.liveness import Flow
from openrois_streaming.stats import StreamStats
from openrois_streaming.stream import Stream
from openrois_streaming.tasks import OwnedTasks, Task
from openrois_streaming.track import PacketTrack

RTX: Final = "video/rtx"
_CLOCK_RATES: Final = {"video": VIDEO_CLOCK_RATE, "audio": AUDIO_CLOCK_RATE}


class Leg:
    """A stream on its way over one m-section."""

    __slots__ = ("_clock", "_feed", "_tasks", "flow", "generation", "report", "section", "stream", "up")

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
        self._tasks = tasks
        self._clock = clock
        self._feed: Task[None] | None = None

    def follow(self) -> None:
        """Send or do not send, as the stream's phase and the media path have it."""
        wanted = self.up and self.stream.is_open
        if wanted and self._feed is None:
            self._open()
        elif not wanted and self._feed is not None:
            self.close()

    def close(self) -> None:
        """Stop sending. The rendition is left at once, so that its encoder can rest."""
        if self._feed is not None:
            self._feed.cancel()
            self._feed = None
        self.flow.closed()
        self.section.track.clear()

    def repair(self) -> None:
        """The viewer cannot decode and asks for a key frame."""
        self.stream.counters.key_frame_requests += 1
        if self._feed is not None:
            self._rendition().request_key_frame(KeyFrameCause.REPAIR)

    def sent(self, frame: EncodedFrame) -> None:
        """The sender took `frame`."""
        self.flow.left(self._clock.now())
        self.stream.counters.sent(frame)

    def reported(self, report: ReceiverReport) -> None:
        """The viewer reported on what it received."""
        self.flow.reported(report.highest_sequence, self._clock.now())
        self.report = report

    async def stats(self) -> StreamStats:
        """The figures of the stream, with what the viewer says about this way."""
        counters, report = self.stream.counters, self.report
        measured = await self.section.transceiver.sender.getStats()
        round_trips = [each.roundTripTime for each in measured.values() if each.type == "remote-inbound-rtp"]
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
            round_trip_time=round_trips[0] if round_trips else None,
            packets_lost=None if report is None else report.packets_lost,
            fraction_lost=None if report is None else report.fraction_lost,
            jitter=None if report is None else report.jitter / _CLOCK_RATES[self.stream.kind],
        )

    def _open(self) -> None:
        self.flow.opened(self._clock.now())
        work = feed(self._rendition, self.section.track, self.stream.counters, self._clock)
        self._feed = self._tasks.start(work, f"feed {self.stream.kind}")

    def _rendition(self) -> SharedRendition:
        codec = self.section.codec
        assert codec is not None, "a leg is up only when its section is negotiated"
        return self.stream.publisher.rendition(codec)


class Section:
    """One m-section. Its transceiver, its track and its codec stay as long as the peer connection; streams change.

    aiortc fixes the codec of a sender with its first packet and cannot take a section out of a description, so a
    section is only ever taken over by a stream of the same kind that may be sent in the same codec.

    `wall_offset` is the time of day (epoch seconds) at which the media clock was 0, the same for all of a viewer.
    """

    def __init__(
        self, connection: RTCPeerConnection, kind: MediaKind, codecs: Sequence[str], wall_offset: float
    ) -> None:
        self.kind: MediaKind = kind
        self.leg: Leg | None = None
        self.codec: str | None = None
        """The negotiated media type; None before the first answer."""
        self.highest_sequence: int | None = None
        """The newest packet the viewer has reported; None before its first report."""
        self._wall_offset = wall_offset
        self._captured_at: float | None = None
        self.track = PacketTrack(kind, self._sent)
        self.transceiver: RTCRtpTransceiver = connection.addTransceiver(self.track, direction="sendonly")
        self._prefer(codecs)
        watch_sender(self.transceiver.sender, on_report=self._reported, on_key_frame=self._key_frame_wanted)
        date_by_capture(self.transceiver.sender, lambda: self._captured_at)

    @property
    def mid(self) -> str:
        """Its name in the descriptions, once one was made."""
        mid = self.transceiver.mid
        assert mid is not None, "a section has its name from the first description on"
        return mid

    def suits(self, stream: Stream) -> bool:
        """Whether it is idle and `stream` can take it over."""
        return self.leg is None and self.kind == stream.kind and self.codec in stream.codecs

    def negotiated(self) -> None:
        """An answer was applied: from now on only the codec it chose is offered.

        A sender that has not started yet would otherwise start with the first codec of a later offer.
        """
        if self.codec is None:
            codec = negotiated_codec(self.transceiver)
            assert codec is not None, "an answer without a common codec is refused"
            self.codec = codec
            self._prefer([codec])

    def _prefer(self, codecs: Sequence[str]) -> None:
        known = RTCRtpSender.getCapabilities(self.kind).codecs
        chosen = [capability for codec in (*codecs, RTX) for capability in known if capability.mimeType == codec]
        self.transceiver.setCodecPreferences(chosen)

    def _sent(self, frame: EncodedFrame) -> None:
        self._captured_at = frame.captured_at + self._wall_offset
        if self.leg is not None:
            self.leg.sent(frame)

    def _reported(self, report: ReceiverReport) -> None:
        self.highest_sequence = report.highest_sequence
        if self.leg is not None:
            self.leg.reported(report)

    def _key_frame_wanted(self) -> None:
        if self.leg is not None:
            self.leg.repair()
