"""RTP receiver: the media of an application in one m-section as a source, repaired and reported on."""

import asyncio
import logging
import random
from collections.abc import Callable
from typing import Any

from aiortc import RTCRtpTransceiver

from openrois_streaming.aiortc_internals.receiving import (
    BitrateEstimate,
    forget_source,
    own_ssrc,
    replace_receiver,
    send_rtcp,
)
from openrois_streaming.clock import MediaClock
from openrois_streaming.receive import feedback
from openrois_streaming.receive.assembly import Request
from openrois_streaming.receive.inbound import Arrived, Inbound, Negotiated, SenderReport
from openrois_streaming.receive.lane import DECODABLE, AudioLane, Captured, Lane, VideoLane
from openrois_streaming.receive.limit import BitrateLimit
from openrois_streaming.receive.remote_time import RemoteClock
from openrois_streaming.receive.source_audio import AudioSource
from openrois_streaming.receive.source_video import MakePicture, raw_picture
from openrois_streaming.source.source import MediaSource
from openrois_streaming.stats import ReceiverFigures
from openrois_streaming.tasks import OwnedTasks

MakeAudioSource = Callable[[MediaClock, Captured], AudioSource]
"""Makes the source of a section's sound."""

REPORT_INTERVAL = 0.75
"""Seconds between two receiver reports, on average."""

_log = logging.getLogger(__name__)


class RtpReceiver:
    """Receiver in place of the receiver of `transceiver`; to be made before the first description.

    `source` is the application's media, a `MediaSource` of `ReceivedVideo` (I420) or `ReceivedAudio` (stereo). It is
    decoded only while it is open. It ends when the peer connection does. `frames` are the whole frames that arrived,
    decoded or not, and `last_frame_at` is when the newest of them did, on `clock`.

    Receivers of one peer connection share `remote`, so that their capture times agree. `make_audio` makes
    the source of sound, `make_picture` what a reader gets of a picture.
    """

    def __init__(
        self,
        transceiver: RTCRtpTransceiver,
        clock: MediaClock,
        remote: RemoteClock | None = None,
        make_audio: MakeAudioSource = AudioSource,
        make_picture: MakePicture[Any] = raw_picture,
    ) -> None:
        self.frames = 0
        self.last_frame_at: float | None = None
        self._kind: str = transceiver.kind
        self._receiver = transceiver.receiver
        self._ssrc = own_ssrc(transceiver)
        self._clock = clock
        self._inbound = Inbound(
            DECODABLE[self._kind],
            remote or RemoteClock(),
            on_change=lambda: self._lane.pause(),
            on_unused=lambda ssrc: forget_source(self._receiver, ssrc),
        )
        self._lane: Lane
        self.source: MediaSource[Any]
        if self._kind == "video":
            video = VideoLane(self._inbound.captured, self._wake_from_anywhere, make_picture)
            self._lane, self.source = video, video.source
        else:
            audio = AudioLane(make_audio(clock, self._inbound.captured))
            self._lane, self.source = audio, audio.source
        self._estimate = BitrateEstimate()
        self._limit = BitrateLimit()
        self._limits: int | None = None
        """The source (SSRC) that was sent a limit."""
        self._wanted = True
        self._packets = self._bytes = self._nacks = self._key_frame_requests = 0
        self._loop = asyncio.get_running_loop()
        self._tasks = OwnedTasks(f"{self._kind} receiver", lambda error: _log.error("a receiver failed: %r", error))
        self._wake = asyncio.Event()
        self._next_check_at = 0.0
        self._started = False
        replace_receiver(transceiver, self)

    def pass_media(self, wanted: bool) -> None:
        """Set whether media is `wanted`; otherwise packets are counted and dropped. Video resumes with a key frame."""
        self._wanted = wanted
        self._lane.pause()

    @property
    def figures(self) -> ReceiverFigures:
        """Counts so far; losses and jitter are of the present source."""
        source = self._inbound.source
        reception = source.reception if source else None
        lane = self._lane.figures
        return ReceiverFigures(
            packets=self._packets,
            bytes=self._bytes,
            packets_lost=max(reception.lost, 0) if reception else 0,
            nacks=self._nacks,
            key_frame_requests=self._key_frame_requests,
            key_frames=lane.key_frames,
            frames_decoded=lane.decoded,
            frames_dropped=lane.dropped,
            jitter=reception.jitter_seconds if reception else 0.0,
            playout_delay=lane.playout_delay,
            concealed=lane.concealed,
        )

    # The following methods are called by the peer connection and its transport.

    async def negotiated(self, parameters: Negotiated) -> None:
        """Apply the parameters of an answer."""
        self._inbound.negotiated(parameters)
        if not self._started:
            self._started = True
            self._tasks.start(self._run(), "reports")

    async def arrived(self, packet: Arrived) -> None:
        """Receive a packet. Never raises, as that would end the transport."""
        try:
            await self._handle_packet(packet, self._clock.now())
        except Exception:
            _log.exception("a packet could not be received")

    def reported(self, report: SenderReport) -> None:
        """Apply a sender report."""
        self._inbound.reported(report, self._clock.now())

    def disconnected(self) -> None:
        """End the source: the transport is disconnected."""
        self._lane.end_input()

    async def stop(self) -> None:
        """Stop with the peer connection; aiortc may still start this receiver afterwards, which has no effect."""
        self._started = True
        self._lane.end_input()
        await self._tasks.aclose()

    async def _handle_packet(self, packet: Arrived, now: float) -> None:
        if not self._inbound.knows(packet):
            return
        self._packets += 1
        self._bytes += packet.size
        media = self._inbound.receive_packet(packet, now)
        if self._kind == "video":
            await self._send_limit(packet, now)
        if media is None or not self._wanted:
            return
        self._count(self._lane.add(media, now), now)
        await self._check_deadlines(now)

    async def _send_limit(self, packet: Arrived, now: float) -> None:
        estimate = self._estimate.add(packet, now)
        if estimate is not None:
            bitrate, full = estimate
            self._limit.estimated(bitrate, now, full=full)
        source = self._inbound.source
        if source is not None and (estimate is not None or self._limits != source.ssrc):
            # Also at the beginning: a browser starts at a limit that comes in its first two seconds.
            self._limits = source.ssrc
            await self._send(feedback.bitrate_limit(self._ssrc, source.ssrc, self._limit.bitrate))

    def _count(self, frames: int, now: float) -> None:
        if frames:
            self.frames += frames
            self.last_frame_at = now

    async def _check_deadlines(self, now: float) -> None:
        frames, request = self._lane.check_deadlines(now)
        self._count(frames, now)
        if request.packets or request.key_frame:
            await self._ask_for(request)
        at = self._lane.next_at
        if at is not None and at < self._next_check_at:
            self._wake.set()

    async def _ask_for(self, request: Request) -> None:
        source = self._inbound.source
        if source is None:
            return
        if request.packets:
            self._nacks += len(request.packets)
            wanted = [each & 0xFFFF for each in request.packets]
            await self._send(feedback.nack(self._ssrc, source.ssrc, wanted))
        if request.key_frame:
            self._key_frame_requests += 1
            await self._send(feedback.picture_loss(self._ssrc, source.ssrc))

    async def _run(self) -> None:
        """Send reports, and check deadlines while no packet comes."""
        report_at = self._clock.now()
        while True:
            now = self._clock.now()
            if now >= report_at:
                report_at = now + REPORT_INTERVAL * random.uniform(0.5, 1.5)  # noqa: S311 - no secret
                await self._report(now)
            self._wake.clear()
            if self._wanted:
                await self._check_deadlines(now)
            at = self._lane.next_at if self._wanted else None
            self._next_check_at = min(report_at, at if at is not None else report_at)
            try:
                async with asyncio.timeout(max(self._next_check_at - self._clock.now(), 0.001)):
                    await self._wake.wait()
            except TimeoutError:
                continue

    async def _report(self, now: float) -> None:
        source = self._inbound.source
        reception = source.reception.report(now) if source else None
        if source is not None and reception is not None:
            self._limit.counted(reception.highest_sequence, reception.packets_lost, self._bytes, now)
            await self._send(feedback.receiver_report(self._ssrc, source.ssrc, reception))

    async def _send(self, packet: bytes) -> None:
        await send_rtcp(self._receiver, packet)

    def _wake_from_anywhere(self) -> None:
        self._loop.call_soon_threadsafe(self._wake.set)
