"""A sender, a process of its own: one source for many viewers, as OpenRoIS sends it or as aiortc alone does.

Run as `python -m openrois_avatar.bench.sender openrois|aiortc CODEC`. Viewers are connected first; how many of them
play is told afterwards.
"""

import asyncio
import itertools
import sys
import time
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from fractions import Fraction
from functools import partial
from typing import Any, Final, Protocol

import av
from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription, VideoStreamTrack
from aiortc.codecs import h264, vpx
from aiortc.rtcconfiguration import RTCBundlePolicy
from openrois_signaling.messages import Answer, Downward, Offer
from openrois_streaming.clock import SystemClock
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.source.source import RawVideo

from openrois.jsonrpc.session import Handler
from openrois_avatar.bench.partner import cpu_seconds, serve
from openrois_avatar.bench.picture import Grain
from openrois_avatar.bench.runs import BITRATE, FPS, HEIGHT, OPENROIS, WIDTH

__all__ = ["LatestPicture", "PlainSender", "Sender", "SharingSender"]

_STREAM: Final = "stream"
_CLOCK_RATE: Final = 90_000


class Sender(Protocol):
    """One way of sending the pictures. Viewers count from 0, in the order in which they were offered."""

    @property
    def encoders(self) -> int:
        """How many encoders run now."""
        ...

    async def offer(self) -> str:
        """Make a connection for one more viewer; returns the SDP of its offer."""
        ...

    async def answer(self, viewer: int, sdp: str) -> None:
        """Take in the answer of a viewer."""
        ...

    def play(self, viewers: int) -> None:
        """Send to the first so many viewers from now on, and to no others."""
        ...


class SharingSender:
    """OpenRoIS: a session for each viewer, and one rendition for all of them."""

    def __init__(self, codec: str, stack: AsyncExitStack) -> None:
        self._codec = codec
        self._stack = stack
        self._clock = SystemClock()
        self._publisher = VideoPublisher(
            Grain(WIDTH, HEIGHT, clock=self._clock), clock=self._clock, max_bitrate=BITRATE
        )
        self._sessions: list[StreamSession] = []
        self._offers: list[Offer] = []
        self._ids = itertools.count()

    @property
    def encoders(self) -> int:
        """How many encoders run now."""
        return self._publisher.running_encoders

    async def offer(self) -> str:
        """Open a session with one stream, which is suspended until it is to play."""
        first: asyncio.Future[Downward] = asyncio.get_running_loop().create_future()
        session = StreamSession(
            mint=lambda: f"peer {next(self._ids)}",
            send=lambda message: None if first.done() else first.set_result(message),
            on_change=lambda _change: None,
            clock=self._clock,
        )
        await self._stack.enter_async_context(session)
        session.connect(_STREAM, "bench", self._publisher, "video", [self._codec])
        session.suspend(_STREAM)
        offer = await first
        assert isinstance(offer, Offer), "a session's first message is an offer"
        self._sessions.append(session)
        self._offers.append(offer)
        return offer.sdp

    async def answer(self, viewer: int, sdp: str) -> None:
        """Hand the answer to its session."""
        offer = self._offers[viewer]
        await self._sessions[viewer].answer(Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=sdp))

    def play(self, viewers: int) -> None:
        """Resume the first so many streams and suspend the others."""
        for number, session in enumerate(self._sessions):
            if number < viewers:
                session.resume(_STREAM)
            else:
                session.suspend(_STREAM)


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

    def __init__(self, codec: str, stack: AsyncExitStack, tasks: asyncio.TaskGroup) -> None:
        self.encoders = 0
        """How many viewers play: aiortc has an encoder for each."""
        self._codec = codec
        self._stack = stack
        self._tracks: list[LatestPicture] = []
        self._connections: list[RTCPeerConnection] = []
        _pin_bitrate()
        stack.callback(tasks.create_task(self._pull()).cancel)

    async def _pull(self) -> None:
        async with Grain(WIDTH, HEIGHT, clock=SystemClock()).open() as pictures:
            async for picture in pictures:
                for track in self._tracks[: self.encoders]:
                    track.show(picture)

    async def offer(self) -> str:
        """Make a peer connection with a track that waits."""
        connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        self._stack.push_async_callback(connection.close)
        track = LatestPicture()
        transceiver = connection.addTransceiver(track, direction="sendonly")
        known = RTCRtpSender.getCapabilities("video").codecs
        transceiver.setCodecPreferences([each for each in known if each.mimeType in (self._codec, "video/rtx")])
        await connection.setLocalDescription(await connection.createOffer())
        self._tracks.append(track)
        self._connections.append(connection)
        return connection.localDescription.sdp

    async def answer(self, viewer: int, sdp: str) -> None:
        """Hand the answer to its peer connection."""
        await self._connections[viewer].setRemoteDescription(RTCSessionDescription(sdp, "answer"))

    def play(self, viewers: int) -> None:
        """Feed the first so many tracks."""
        self.encoders = viewers


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
async def _role(way: str, codec: str) -> AsyncIterator[Mapping[str, Handler]]:
    async with asyncio.TaskGroup() as tasks, AsyncExitStack() as stack:
        sender: Sender = SharingSender(codec, stack) if way == OPENROIS else PlainSender(codec, stack, tasks)

        async def offer(_params: dict[str, Any]) -> str:
            return await sender.offer()

        async def answer(params: dict[str, Any]) -> None:
            await sender.answer(params["viewer"], params["sdp"])

        async def play(params: dict[str, Any]) -> None:
            sender.play(params["viewers"])

        async def read(_params: dict[str, Any]) -> dict[str, Any]:
            return {"at": time.monotonic(), "cpu": cpu_seconds(), "encoders": sender.encoders}

        yield {"offer": offer, "answer": answer, "play": play, "read": read}


if __name__ == "__main__":
    serve(partial(_role, sys.argv[1], sys.argv[2]))
