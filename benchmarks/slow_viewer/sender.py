"""Sends one moving picture to several viewers, as OpenRoIS does or as aiortc alone does; asked through pipes.

Run by `__main__` as `python -m benchmarks.slow_viewer.sender openrois|aiortc CODEC`.
"""

import asyncio
import itertools
import json
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import asdict
from functools import partial
from typing import Any, Protocol

from aiortc import RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription
from aiortc.rtcconfiguration import RTCBundlePolicy
from openrois_avatar.bench.partner import cpu_seconds, serve
from openrois_avatar.bench.picture import Grain
from openrois_avatar.bench.sender import LatestPicture
from openrois_signaling.messages import Answer, Downward, Offer
from openrois_streaming.clock import SystemClock, wall_at
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.session.session import StreamSession
from openrois_streaming.source.stamp import stamped

WIDTH, HEIGHT, FPS = 1280, 720, 30
STREAM = "stream"


class Sender(Protocol):
    """One way of sending the picture to viewers, who have names."""

    async def offer(self, viewer: str) -> str:
        """Connect one more viewer; returns the SDP of the offer."""
        ...

    async def answer(self, viewer: str, sdp: str) -> None:
        """Take in its answer."""
        ...

    async def leave(self, viewer: str) -> None:
        """Let it go."""
        ...

    async def figures(self) -> dict[str, Any]:
        """What was counted."""
        ...


class Sharing:
    """OpenRoIS: one publisher, and a session for each viewer."""

    def __init__(self, codec: str, stack: AsyncExitStack) -> None:
        self._codec, self._stack, self._clock = codec, stack, SystemClock()
        self._publisher = VideoPublisher(
            Grain(WIDTH, HEIGHT, clock=self._clock), clock=self._clock, stamp=True, frame_rate=FPS
        )
        self._sessions: dict[str, tuple[StreamSession, Offer]] = {}
        self._ids = itertools.count()

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
        session.connect(STREAM, "bench", self._publisher, "video", [self._codec])
        offer = await first
        assert isinstance(offer, Offer), "a session's first message is an offer"
        self._sessions[viewer] = (session, offer)
        return offer.sdp

    async def answer(self, viewer: str, sdp: str) -> None:
        """Hand the answer to its session."""
        session, offer = self._sessions[viewer]
        await session.answer(Answer(peer_id=offer.peer_id, generation=offer.generation, sdp=sdp))

    async def leave(self, viewer: str) -> None:
        """Close its session."""
        session, _ = self._sessions.pop(viewer)
        await session.close("done")

    async def figures(self) -> dict[str, Any]:
        """Streams and renditions."""
        streams = {viewer: asdict(await session.stats(STREAM)) for viewer, (session, _) in self._sessions.items()}
        figures = {"streams": streams, "renditions": [asdict(each.figures()) for each in self._publisher.made]}
        plain: dict[str, Any] = json.loads(json.dumps(figures, default=str))
        return plain


class Plain:
    """aiortc alone: a track and an encoder for each viewer, at the rate that aiortc chooses."""

    def __init__(self, codec: str, tasks: asyncio.TaskGroup, stack: AsyncExitStack) -> None:
        self._codec, self._clock = codec, SystemClock()
        self._viewers: dict[str, tuple[RTCPeerConnection, LatestPicture]] = {}
        stack.callback(tasks.create_task(self._pull()).cancel)

    async def _pull(self) -> None:
        async with Grain(WIDTH, HEIGHT, clock=self._clock).open() as pictures:
            async for picture in pictures:
                if self._viewers:
                    shown = stamped(picture, wall_at(self._clock, picture.captured_at))
                    for _, track in self._viewers.values():
                        track.show(shown)

    async def offer(self, viewer: str) -> str:
        """Make a peer connection with a track."""
        connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        track = LatestPicture()
        transceiver = connection.addTransceiver(track, direction="sendonly")
        known = RTCRtpSender.getCapabilities("video").codecs
        transceiver.setCodecPreferences([each for each in known if each.mimeType in (self._codec, "video/rtx")])
        await connection.setLocalDescription(await connection.createOffer())
        self._viewers[viewer] = (connection, track)
        sdp: str = connection.localDescription.sdp
        return sdp

    async def answer(self, viewer: str, sdp: str) -> None:
        """Hand the answer to its peer connection."""
        await self._viewers[viewer][0].setRemoteDescription(RTCSessionDescription(sdp, "answer"))

    async def leave(self, viewer: str) -> None:
        """Close its peer connection."""
        connection, _ = self._viewers.pop(viewer)
        await connection.close()

    async def figures(self) -> dict[str, Any]:
        """There are none."""
        return {"streams": {}, "renditions": []}


@asynccontextmanager
async def _role(way: str, codec: str) -> AsyncIterator[Mapping[str, Any]]:
    async with asyncio.TaskGroup() as tasks, AsyncExitStack() as stack:
        sender: Sender = Sharing(codec, stack) if way == "openrois" else Plain(codec, tasks, stack)

        async def offer(params: dict[str, Any]) -> str:
            return await sender.offer(params["viewer"])

        async def answer(params: dict[str, Any]) -> None:
            await sender.answer(params["viewer"], params["sdp"])

        async def leave(params: dict[str, Any]) -> None:
            await sender.leave(params["viewer"])

        async def read(_params: dict[str, Any]) -> dict[str, Any]:
            return {"cpu": cpu_seconds(), **await sender.figures()}

        yield {"offer": offer, "answer": answer, "leave": leave, "read": read}


if __name__ == "__main__":
    serve(partial(_role, sys.argv[1], sys.argv[2]))
