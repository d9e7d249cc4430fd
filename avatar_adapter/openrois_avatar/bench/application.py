"""An application that plays one video stream in aiortc, as any other would: over the gateway, and decoding it."""

import asyncio
import json
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any, Final, cast

import av
import numpy as np
from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.rtcconfiguration import RTCBundlePolicy
from numpy.typing import NDArray
from openrois_streaming import stamp
from openrois_streaming.stamp import Stamp

from openrois.jsonrpc.session import RpcSession
from openrois.transport.websocket import dial
from openrois_avatar.bench.errors import BenchFailed, within

__all__ = ["Application", "Picture", "Playing", "application"]

_PATIENCE: Final = 15.0
"""Seconds for an offer, or for a picture; a machine that needs longer cannot be measured."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A decoded picture: when it was there (`at` monotonic, `wall` epoch seconds), and its stamp if it has one."""

    at: float
    wall: float
    width: int
    height: int
    stamp: Stamp | None


class Playing:
    """A stream that plays."""

    def __init__(self, application: "Application", stream_id: str, track: MediaStreamTrack, asked_at: float) -> None:
        self.asked_at = asked_at
        """Monotonic time at which the stream was asked for."""
        self._application = application
        self._stream_id = stream_id
        self._track = track

    async def picture(self) -> Picture:
        """The next picture.

        Raises:
            BenchFailed: none comes.
        """
        async with within(_PATIENCE, "the next picture"):
            frame = cast(av.VideoFrame, await self._track.recv())
        at, wall = time.monotonic(), time.time()
        return Picture(at, wall, frame.width, frame.height, stamp.read(_luma(frame)))

    async def ask(self, verb: str) -> None:
        """Have the stream do one of the streaming verbs."""
        await self._application.ask(f"rois.stream.{verb}_stream", stream_id=self._stream_id)


class Application:
    """A session at the gateway."""

    def __init__(self, session: RpcSession) -> None:
        self._session = session
        self._offers: asyncio.Queue[dict[str, Any]] = asyncio.Queue(16)
        session.notifications = {"signaling.offer": self._offers.put_nowait}

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        """Call a method and return its result.

        Raises:
            BenchFailed: the answer is not OK.
        """
        result: dict[str, Any] = await self._session.call(method, params)
        if result["return_code"] != "OK":
            raise BenchFailed(f"{method} was answered {result['return_code']}")
        return result

    @asynccontextmanager
    async def playing(self, component_ref: str, codec: str) -> AsyncIterator[Playing]:
        """Play the stream of a component for as long as the context lasts.

        Raises:
            BenchFailed: it is refused, or no offer comes.
        """
        encoding = {
            "name": "encoding_parameters",
            "data_type_ref": "string",
            "value": json.dumps({"codecs": [codec]}),
        }
        asked_at = time.monotonic()
        connected = await self.ask("rois.stream.connect_stream", component_ref=component_ref, parameters=[encoding])
        async with within(_PATIENCE, "the offer"):
            offer = await self._offers.get()
        connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
        try:
            await connection.setRemoteDescription(RTCSessionDescription(offer["sdp"], "offer"))
            await connection.setLocalDescription(await connection.createAnswer())
            await self.ask(
                "signaling.answer",
                peer_id=offer["peer_id"],
                generation=offer["generation"],
                sdp=connection.localDescription.sdp,
            )
            track = connection.getReceivers()[0].track
            yield Playing(self, connected["stream_id"], track, asked_at)
            await self.ask("rois.stream.disconnect_stream", stream_id=connected["stream_id"])
        finally:
            await connection.close()


@asynccontextmanager
async def application(url: str) -> AsyncIterator[Application]:
    """Connect to the gateway at `url` (`ws://host:port/`) as an application, for as long as the context lasts."""
    async with dial(url) as stream:
        session = RpcSession(stream)
        connected = Application(session)
        running = asyncio.create_task(session.run(), name="application")
        try:
            await connected.ask("rois.system.connect")
            yield connected
        finally:
            await session.close()
            await asyncio.wait({running})


def _luma(frame: av.VideoFrame) -> NDArray[np.uint8]:
    """The Y plane of a decoded picture, as a view."""
    plane = frame.planes[0]
    rows = np.frombuffer(memoryview(plane), np.uint8).reshape(-1, plane.line_size)
    return rows[: frame.height, : frame.width]
