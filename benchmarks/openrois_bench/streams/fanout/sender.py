"""A sender, a process of its own: one source for many viewers, as OpenRoIS sends it or as aiortc alone does.

Run as `python -m openrois_bench.streams.fanout.sender openrois|aiortc CODEC pinned|free`. What is pinned keeps to one
bit rate, and its viewers are connected first: which of them play is told afterwards. Otherwise the sender chooses the
rate, viewers play when they are connected, and pictures bear a stamp.
"""

import asyncio
import itertools
import sys
import time
from collections.abc import AsyncIterator, Collection, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from fractions import Fraction
from functools import partial
from typing import Any, Final, Protocol

import av
from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription, VideoStreamTrack
from aiortc.codecs import h264, vpx
from aiortc.rtcconfiguration import RTCBundlePolicy
from openrois_signaling.messages import Answer, Downward, Offer
from openrois_streaming.clock import SystemClock, wall_at
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.source.source import RawVideo
from openrois_streaming.source.stamp import stamped

from openrois.jsonrpc.session import Handler
from openrois_bench.processes.partner import cpu_seconds, serve
from openrois_bench.streams.fanout.picture import Grain
from openrois_bench.streams.fanout.runs import BITRATE, FPS, HEIGHT, OPENROIS, WIDTH

__all__ = ["LatestPicture", "PlainSender", "Sender", "SharingSender"]

_STREAM: Final = "stream"
_CLOCK_RATE: Final = 90_000


class Sender(Protocol):
    """One way of sending the pictures to viewers, who have names."""

    @property
    def encoders(self) -> int:
        """Number of encoders that run now."""
        ...

    @property
    def repairs(self) -> int:
        """Number of key frames that were made because a viewer lost data."""
        ...

    async def offer(self, viewer: str) -> str:
        """Make a connection for one more viewer; returns the SDP of its offer."""
        ...

    async def apply_answer(self, viewer: str, sdp: str) -> None:
        """Take in the answer of a viewer."""
        ...

    def play(self, viewers: Collection[str]) -> None:
        """Send to these viewers from now on, and to no others."""
        ...

    async def leave(self, viewer: str) -> None:
        """Close the connection of a viewer."""
        ...


class SharingSender:
    """OpenRoIS: a session for each viewer, and one rendition for all of them."""

    def __init__(self, codec: str, stack: AsyncExitStack, *, pinned: bool) -> None:
        self._codec = codec
        self._stack = stack
        self._pinned = pinned
        self._clock = SystemClock()
        self._publisher = VideoPublisher(
            Grain(WIDTH, HEIGHT, clock=self._clock),
            clock=self._clock,
            max_bitrate=BITRATE if pinned else None,
            stamp=not pinned,
        )
        self._sessions: dict[str, tuple[StreamSession, Offer]] = {}
        self._ids = itertools.count()

    @property
    def encoders(self) -> int:
        """Number of encoders that run now."""
        return self._publisher.running_encoders

    @property
    def repairs(self) -> int:
        """Number of key frames that were made because a viewer lost data."""
        return sum(each.figures().repairs for each in self._publisher.made)

    async def offer(self, viewer: str) -> str:
        """Open a session with one stream."""
        first: asyncio.Future[Downward] = asyncio.get_running_loop().create_future()
        session = StreamSession(
            mint=lambda: f"peer {next(self._ids)}",
            send=lambda message: None if first.done() else first.set_result(message),
            on_change=lambda _change: None,
            clock=self._clock,
        )
        await self._stack.enter_async_context(session)
        session.connect(_STREAM, "bench", self._publisher, "video", [self._codec])
        if self._pinned:
            session.suspend(_STREAM)
        offer = await first
        assert isinstance(offer, Offer), "a session's first message is an offer"
        self._sessions[viewer] = session, offer
        return offer.sdp

    async def apply_answer(self, viewer: str, sdp: str) -> None:
        """Hand the answer to its session."""
        session, offer = self._sessions[viewer]
        await session.apply_answer(Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=sdp))

    def play(self, viewers: Collection[str]) -> None:
        """Resume the streams of these viewers and suspend the others."""
        for viewer, (session, _) in self._sessions.items():
            if viewer in viewers:
                session.resume(_STREAM)
            else:
                session.suspend(_STREAM)

    async def leave(self, viewer: str) -> None:
        """Close its session."""
        session, _ = self._sessions.pop(viewer)
        await session.close("done")


class LatestPicture(VideoStreamTrack):
    """A track as aiortc's own: it hands out pictures, and the peer connection encodes them.

    A picture that the encoder has no time for is lost; without that, a busy machine would fall behind for good.
    """

    def __init__(self) -> None:
        super().__init__()
        self._picture: RawVideo | None = None
        self._shown = asyncio.Event()

    def show(self, picture: RawVideo) -> None:
        """Have `picture` sent next, if it is not overtaken."""
        self._picture = picture
        self._shown.set()

    async def recv(self) -> av.VideoFrame:
        """Wait for the next picture."""
        await self._shown.wait()
        self._shown.clear()
        assert self._picture is not None
        frame = av.VideoFrame.from_numpy_buffer(self._picture.data, format="yuv420p")
        frame.pts, frame.time_base = self._picture.sequence * _CLOCK_RATE // FPS, Fraction(1, _CLOCK_RATE)
        return frame


class PlainSender:
    """aiortc alone: a track and an encoder for each viewer, all fed from one source."""

    repairs = 0
    """aiortc does not count them."""

    def __init__(self, codec: str, stack: AsyncExitStack, tasks: asyncio.TaskGroup, *, pinned: bool) -> None:
        self._codec = codec
        self._stack = stack
        self._pinned = pinned
        self._clock = SystemClock()
        self._viewers: dict[str, tuple[RTCPeerConnection, LatestPicture]] = {}
        self._playing: set[str] = set()
        if pinned:
            _pin_bitrate()
        stack.callback(tasks.create_task(self._pull()).cancel)

    @property
    def encoders(self) -> int:
        """Number of viewers that play: aiortc has an encoder for each."""
        return len(self._playing)

    async def _pull(self) -> None:
        async with Grain(WIDTH, HEIGHT, clock=self._clock).open() as pictures:
            async for picture in pictures:
                if not self._playing:
                    continue
                shown = picture if self._pinned else stamped(picture, wall_at(self._clock, picture.captured_at))
                for viewer in self._playing:
                    self._viewers[viewer][1].show(shown)

    async def offer(self, viewer: str) -> str:
        """Make a peer connection with a track."""
        connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        self._stack.push_async_callback(connection.close)
        track = LatestPicture()
        transceiver = connection.addTransceiver(track, direction="sendonly")
        known = RTCRtpSender.getCapabilities("video").codecs
        transceiver.setCodecPreferences([each for each in known if each.mimeType in (self._codec, "video/rtx")])
        await connection.setLocalDescription(await connection.createOffer())
        self._viewers[viewer] = connection, track
        if not self._pinned:
            self._playing.add(viewer)
        sdp: str = connection.localDescription.sdp
        return sdp

    async def apply_answer(self, viewer: str, sdp: str) -> None:
        """Hand the answer to its peer connection."""
        await self._viewers[viewer][0].setRemoteDescription(RTCSessionDescription(sdp, "answer"))

    def play(self, viewers: Collection[str]) -> None:
        """Feed the tracks of these viewers."""
        self._playing = set(viewers)

    async def leave(self, viewer: str) -> None:
        """Close its peer connection."""
        self._playing.discard(viewer)
        connection, _ = self._viewers.pop(viewer)
        await connection.close()


def _pin_bitrate() -> None:
    """Have aiortc's encoders keep to `BITRATE`: VP8 starts at half of it, and both follow the receiver's estimate.

    Raises:
        AttributeError: this aiortc has other names for its limits.
    """
    for module in (h264, vpx):
        for name in ("DEFAULT_BITRATE", "MIN_BITRATE", "MAX_BITRATE"):
            getattr(module, name)
            setattr(module, name, BITRATE)


@asynccontextmanager
async def _role(way: str, codec: str, rate: str) -> AsyncIterator[Mapping[str, Handler]]:
    pinned = rate == "pinned"
    async with asyncio.TaskGroup() as tasks, AsyncExitStack() as stack:
        sender: Sender = (
            SharingSender(codec, stack, pinned=pinned)
            if way == OPENROIS
            else PlainSender(codec, stack, tasks, pinned=pinned)
        )

        async def offer(params: dict[str, Any]) -> str:
            return await sender.offer(params["viewer"])

        async def answer(params: dict[str, Any]) -> None:
            await sender.apply_answer(params["viewer"], params["sdp"])

        async def play(params: dict[str, Any]) -> None:
            sender.play(params["viewers"])

        async def leave(params: dict[str, Any]) -> None:
            await sender.leave(params["viewer"])

        async def read(_params: dict[str, Any]) -> dict[str, Any]:
            figures = {"encoders": sender.encoders, "repairs": sender.repairs}
            return {"at": time.monotonic(), "cpu": cpu_seconds(), **figures}

        yield {"offer": offer, "answer": answer, "play": play, "leave": leave, "read": read}


if __name__ == "__main__":
    serve(partial(_role, *sys.argv[1:4]))
