"""A gateway and a body in one process: pictures that were encoded before, and sound with a marker each second.

Run by `__main__` as `python -m openrois_bench.streams.receiving.sender`; it prints where the gateway listens, and the
time of this machine's monotonic clock at which picture 0 is sent. Picture n is sent n / FPS later, if it is watched.
"""

import asyncio
import itertools
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final

import uvloop
from openrois_media.components import AudioStreaming, VideoStreaming
from openrois_media.streaming_interface import Published, StreamingInterface
from openrois_streaming.clock import SystemClock
from openrois_streaming.codecs import H264, OPUS
from openrois_streaming.publish.passthrough import EncodedPublisher
from openrois_streaming.publish.publisher import AudioPublisher
from openrois_streaming.source.source import EncodedVideo
from openrois_streaming.synthetic import Tone

from openrois.adapter.dialer import serve_parent
from openrois.adapter.running import hosted
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.types.codes import ComponentStatus
from openrois.types.references import reference
from openrois_bench.processes.partner import SWITCH_INTERVAL
from openrois_bench.streams.uplink.media import FPS, FRAMES, HEIGHT, WIDTH, encoded

__all__ = ["CAMERA", "MICROPHONE"]

_ENGINE: Final = "bench"
CAMERA: Final = reference(_ENGINE, VideoStreaming.component_type.name)
MICROPHONE: Final = reference(_ENGINE, AudioStreaming.component_type.name)


class _Prepared:
    """`EncodingSource` that sends the same pictures over and over; the first of them is a key frame."""

    def __init__(self, pictures: list[bytes], epoch: float) -> None:
        self._pictures = pictures
        self._epoch = epoch

    def request_key_frame(self) -> None:
        """Ignore the request: there is one each second."""

    def set_bitrate(self, bitrate: int) -> None:
        """Ignore it."""

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[EncodedVideo]]:
        """Send what is due from now on."""
        yield self._due()

    async def _due(self) -> AsyncIterator[EncodedVideo]:
        clock = SystemClock()
        for number in itertools.count(max(int((clock.now() - self._epoch) * FPS), 0)):
            at = self._epoch + number / FPS
            await clock.sleep_until(at)
            index = number % FRAMES
            yield EncodedVideo(self._pictures[index], index == 0, WIDTH, HEIGHT, number, at)


def _ready() -> ComponentStatus:
    return ComponentStatus.READY


async def _run() -> None:
    clock = SystemClock()
    pictures = encoded(H264)
    epoch = time.monotonic()
    published = {
        CAMERA: Published(EncodedPublisher(_Prepared(pictures, epoch), clock=clock, frame_rate=FPS), "video"),
        MICROPHONE: Published(AudioPublisher(Tone(clock=clock), clock=clock), "audio"),
    }
    streams = StreamingInterface(_ENGINE, published, clock)
    camera = VideoStreaming((H264,), ("recvonly",), _ready)
    microphone = AudioStreaming((OPUS,), ("recvonly",), _ready)
    attached = asyncio.Event()
    async with (
        run_gateway(GatewaySettings(port=0)) as gateway,
        streams.sessions,
        hosted(_ENGINE, camera, microphone, extension=streams) as host,
        asyncio.TaskGroup() as tasks,
    ):
        gateway.engine.on_change(attached.set)
        tasks.create_task(serve_parent(host, f"{gateway.url.replace('http', 'ws', 1)}adapter"))
        await attached.wait()
        print(gateway.url.replace("http", "ws", 1), epoch, flush=True)


if __name__ == "__main__":
    sys.setswitchinterval(SWITCH_INTERVAL)
    uvloop.run(_run())
