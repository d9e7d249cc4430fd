"""An application that plays one stream and says when what was sent was decoded, in a process of its own.

Run by `__main__` as `python -m openrois_bench.streams.receiving.viewer RECEIVER MEDIA URL EPOCH`; it prints a line of
JSON.
"""

import asyncio
import json
import sys
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Any, Final, Literal

import numpy as np
from aiortc import MediaStreamTrack, RTCConfiguration, RTCPeerConnection, RTCSessionDescription
from aiortc.mediastreams import MediaStreamError
from aiortc.rtcconfiguration import RTCBundlePolicy
from numpy.typing import NDArray
from openrois_media import Media
from openrois_streaming.codecs import H264
from openrois_streaming.source import stamp

from openrois.client import Client
from openrois.client.components import AudioStreaming, VideoStreaming
from openrois_bench.measuring.figures import MILLISECONDS, Percentiles
from openrois_bench.streams.receiving.sender import CAMERA, MICROPHONE
from openrois_bench.streams.uplink.media import FPS, FRAMES, MarkerFinder

__all__ = ["MEDIA", "RECEIVERS", "MediaName", "Receiver"]

Receiver = Literal["aiortc", "openrois"]
MediaName = Literal["i420", "rgb24", "sound"]
RECEIVERS: Final[tuple[Receiver, ...]] = ("aiortc", "openrois")
MEDIA: Final[tuple[MediaName, ...]] = ("i420", "rgb24", "sound")

_SETTLING: Final = 2.5
_WATCHED: Final = 6.0

OnMedia = Callable[[NDArray[Any]], None]
"""Is given the pixels of each picture, or the samples of each block in the shape (n, channels)."""


class Seen:
    """What was decoded, and how long after it was sent."""

    def __init__(self, media: MediaName, epoch: float) -> None:
        self.delays: list[float] = []
        self.count = 0
        self._media = media
        self._epoch = epoch
        self._markers = MarkerFinder()

    def add_media(self, data: NDArray[Any]) -> None:
        """Take a picture or a block that was decoded now."""
        now = time.monotonic()
        self.count += 1
        if self._media == "sound":
            self._hear(data, now)
            return
        luma = data[: data.shape[0] * 2 // 3] if self._media == "i420" else np.ascontiguousarray(data[-32:, :, 1])
        found = stamp.read(luma)
        if found is not None:
            # Of all times at which this picture was sent, the last one.
            sent = int((now - self._epoch) * FPS)
            sent -= (sent - found.number) % FRAMES
            self.delays.append(now - self._epoch - sent / FPS)

    def _hear(self, samples: NDArray[np.int16], now: float) -> None:
        before = len(self._markers.heard)
        self._markers.add(samples, now)
        for at in self._markers.heard[before:]:
            # A marker is sent at each whole second of the time of day.
            self.delays.append((at + time.time() - time.monotonic()) % 1)


async def openrois(url: str, media: MediaName, on_media: OnMedia) -> None:
    """Play with `Media`, until this is cancelled."""
    async with Client(url) as client, Media(client) as played:
        if media == "sound":
            async with played.blocks(MICROPHONE) as blocks:
                async for block in blocks:
                    on_media(block.samples)
        else:
            async with played.frames(CAMERA, media) as frames:
                async for frame in frames:
                    on_media(frame.data)


async def aiortc(url: str, media: MediaName, on_media: OnMedia) -> None:
    """Play with aiortc alone, until this is cancelled."""
    async with Client(url) as client, _track(client, media) as track:
        while True:
            frame: Any = await track.recv()
            if media == "sound":
                on_media(np.reshape(frame.to_ndarray(), (-1, 2)))
            else:
                on_media(frame.to_ndarray(format="yuv420p" if media == "i420" else media))


@asynccontextmanager
async def _track(client: Client, media: MediaName) -> AsyncIterator[MediaStreamTrack]:
    offers = client.notifications("signaling.offer")
    if media == "sound":
        await client.component(AudioStreaming, MICROPHONE).connect_stream()
    else:
        await client.component(VideoStreaming, CAMERA).connect_stream(encoding={"codecs": [H264]})
    offer = (await anext(offers)).params
    connection = RTCPeerConnection(RTCConfiguration(iceServers=[], bundlePolicy=RTCBundlePolicy.MAX_BUNDLE))
    tracks: list[MediaStreamTrack] = []
    connection.on("track", tracks.append)
    try:
        await connection.setRemoteDescription(RTCSessionDescription(offer["sdp"], "offer"))
        await connection.setLocalDescription(await connection.createAnswer())
        await client.call(
            "signaling.answer",
            peer_id=offer["peer_id"],
            generation=offer["generation"],
            sdp=connection.localDescription.sdp,
        )
        yield tracks[0]
    finally:
        await connection.close()


async def watch(receiver: Receiver, media: MediaName, url: str, epoch: float) -> dict[str, float]:
    """Play for some seconds; returns the figures."""
    seen = Seen(media, epoch)
    play = openrois if receiver == "openrois" else aiortc
    playing = asyncio.create_task(play(url, media, seen.add_media))
    await asyncio.wait({playing}, timeout=_SETTLING)
    seen.delays.clear()
    before, cpu = seen.count, time.process_time()
    await asyncio.wait({playing}, timeout=_WATCHED)
    cpu = time.process_time() - cpu
    per_second = (seen.count - before) / _WATCHED
    playing.cancel()
    with suppress(asyncio.CancelledError, MediaStreamError):
        await playing
    found = Percentiles.of(seen.delays, MILLISECONDS)
    return {
        "p50_ms": found.p50,
        "p95_ms": found.p95,
        "per_second": round(per_second, 1),
        "cpu": round(cpu / _WATCHED, 4),
    }


if __name__ == "__main__":
    _, who, what, where, since = sys.argv
    print(json.dumps(asyncio.run(watch(who, what, where, float(since)))), flush=True)  # type: ignore[arg-type]
