"""A rendition with a source, a clock and encoders in the hand of the test."""

import asyncio
import threading

from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.encoding import Encoding
from openrois_streaming.publish.rendition import encoded_rendition
from openrois_streaming.source.fanout import Fanout, Subscription
from openrois_streaming.source.source import RawVideo

from tests.support.streaming import FakeEncoders, FedSource, VirtualClock, picture

FRAME = 0.03


class Stage:
    """A rendition with a source, a clock and encoders in the test's hand."""

    def __init__(self, *, predicted: bool = True, fresh: float | None = None) -> None:
        self.clock = VirtualClock()
        self.source: FedSource[RawVideo] = FedSource()
        self.encoders = FakeEncoders()
        self.raw = Fanout(self.source, name="stage")
        is_fresh = None if fresh is None else lambda raw, now: now - raw.captured_at <= fresh
        encoding = Encoding("video/H264", 90_000, self.encoders, predicted, depth=1, is_fresh=is_fresh)
        self.rendition = encoded_rendition(self.raw, encoding, clock=self.clock, bitrate=1000)
        self.next = 0

    async def shoot(self, watcher: Subscription[EncodedFrame]) -> EncodedFrame:
        """Let one frame period pass and a frame be captured, and wait until `watcher` has it encoded."""
        await self.clock.advance(FRAME)
        await self.source.feed(picture(self.next, self.clock.now()))
        self.next += 1
        return await got(watcher)

    @property
    def threads(self) -> int:
        """Encoder threads that are alive."""
        return sum(thread.name == "stage video/H264" for thread in threading.enumerate())


async def got(subscription: Subscription[EncodedFrame]) -> EncodedFrame:
    async with asyncio.timeout(60):
        return await subscription.get()
