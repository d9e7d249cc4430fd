"""A connection over which an application sends to an engine, which has aiortc's receiver or ours."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any, Final, Literal

import numpy as np
from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCRtpSender, RTCSessionDescription
from aiortc.mediastreams import MediaStreamError
from aiortc.rtcconfiguration import RTCBundlePolicy
from numpy.typing import NDArray
from openrois_streaming.clock import SystemClock
from openrois_streaming.peer.receiver import RtpReceiver
from openrois_streaming.testing.path import ImpairedPath

Receiver = Literal["aiortc", "openrois"]
RECEIVERS: Final[tuple[Receiver, ...]] = ("aiortc", "openrois")

OnFrame = Callable[[NDArray[Any]], None]
"""Is given the luma of each picture, or the samples of each block in the shape (n, channels)."""


@asynccontextmanager
async def connected(
    receiver: Receiver, codec: str, track: MediaStreamTrack, on_frame: OnFrame
) -> AsyncIterator[ImpairedPath]:
    """Send `track`, in `codec`, to a receiver that is read all the time; yields the path of its packets."""
    configuration = RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE)
    engine, application = RTCPeerConnection(configuration), RTCPeerConnection(configuration)
    tracks: list[MediaStreamTrack] = []
    engine.on("track", tracks.append)
    async with ImpairedPath() as path:
        transceiver = engine.addTransceiver(track.kind, direction="recvonly")
        known = RTCRtpSender.getCapabilities(track.kind).codecs
        transceiver.setCodecPreferences([each for each in known if each.mimeType in (codec, "video/rtx")])
        ours = RtpReceiver(transceiver, SystemClock()) if receiver == "openrois" else None
        reading: asyncio.Task[None] | None = None
        try:
            await engine.setLocalDescription(await engine.createOffer())
            await application.setRemoteDescription(_bent(engine.localDescription, path.to_viewer))
            (sending,) = application.getTransceivers()
            sending.sender.replaceTrack(track)
            sending.direction = "sendonly"
            await application.setLocalDescription(await application.createAnswer())
            await engine.setRemoteDescription(_bent(application.localDescription, path.to_engine))
            reading = asyncio.create_task(_read(ours, on_frame) if ours else _read_track(tracks[0], on_frame))
            yield path
        finally:
            if reading is not None:
                reading.cancel()
                await asyncio.wait({reading})
            await application.close()
            await engine.close()


def _bent(description: RTCSessionDescription, way: Callable[[str], str]) -> RTCSessionDescription:
    return RTCSessionDescription(way(description.sdp), description.type)


async def _read(receiver: RtpReceiver, on_frame: OnFrame) -> None:
    async with receiver.source.open() as frames:
        async for frame in frames:
            on_frame(frame.data[: frame.height] if hasattr(frame, "data") else frame.samples)


async def _read_track(track: MediaStreamTrack, on_frame: OnFrame) -> None:
    try:
        while True:
            frame: Any = await track.recv()
            data = frame.to_ndarray()
            on_frame(data[: frame.height] if track.kind == "video" else np.reshape(data, (-1, 2)))
    except MediaStreamError:
        return
