import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from openrois_streaming.feed import RETRY, feed
from openrois_streaming.keyframes import KeyFrameCause
from openrois_streaming.stats import Counters
from openrois_streaming.track import PacketTrack

from tests.support.streaming import VirtualClock, settle
from tests.support.viewing import FedPublisher, FedRendition, frame


class Feeding:
    """A feed from a rendition to a track, and the sequences that a sender took."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.counters = Counters()
        self.taken: list[int] = []
        self.track = PacketTrack("video", lambda each: self.taken.append(each.sequence))
        self.publisher = FedPublisher()

    @property
    def rendition(self) -> FedRendition:
        return self.publisher.rendition("video/VP8")

    async def take(self, number: int) -> None:
        async with asyncio.timeout(1):
            for _ in range(number):
                await self.track.recv()


@pytest.fixture
async def feeding() -> AsyncIterator[Feeding]:
    feeding = Feeding()
    task = asyncio.create_task(
        feed(lambda: feeding.publisher.rendition("video/VP8"), feeding.track, feeding.counters, feeding.clock)
    )
    await settle()
    yield feeding
    feeding.publisher.failure = None
    assert not task.done()
    task.cancel()
    await asyncio.wait({task})
    assert feeding.rendition.readers == 0


async def test_frames_reach_the_track_from_a_key_frame_on(feeding: Feeding) -> None:
    assert feeding.rendition.asked == [KeyFrameCause.START]
    await feeding.rendition.source.feed(frame(4), frame(5, keyframe=True), frame(6))
    taking = asyncio.create_task(feeding.take(2))
    await taking
    assert feeding.taken == [5, 6]
    assert feeding.counters.frames_dropped == 1


async def test_a_gap_asks_for_a_repair_and_sends_nothing_that_cannot_be_decoded(feeding: Feeding) -> None:
    taking = asyncio.create_task(feeding.take(3))
    await feeding.rendition.source.feed(frame(1, keyframe=True), frame(2), frame(4), frame(5), frame(6, keyframe=True))
    await taking
    assert feeding.taken == [1, 2, 6]
    assert feeding.rendition.asked == [KeyFrameCause.START, KeyFrameCause.REPAIR]
    assert feeding.counters.frames_dropped == 2


async def test_a_slow_sender_loses_frames_counts_them_and_goes_on_with_a_key_frame(feeding: Feeding) -> None:
    for number in range(20):
        await feeding.rendition.source.feed(frame(number, keyframe=number == 0))
    taking = asyncio.create_task(feeding.take(3))
    await settle()
    await feeding.rendition.source.feed(frame(20), frame(21, keyframe=True))
    await taking
    assert feeding.taken[:2] == [0, 1]
    assert feeding.taken[-1] == 21
    assert KeyFrameCause.REPAIR in feeding.rendition.asked
    assert feeding.counters.frames_dropped == 22 - len(feeding.taken)


async def test_a_source_that_fails_is_tried_again_and_said_once(
    feeding: Feeding, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING, logger="openrois_streaming.feed"):
        await feeding.rendition.source.end(OSError("camera unplugged"))
        feeding.publisher.failure = OSError("no camera")
        for _ in range(3):
            await feeding.clock.advance(RETRY)
        feeding.publisher.failure = None
        await feeding.clock.advance(RETRY)
        taking = asyncio.create_task(feeding.take(1))
        await feeding.rendition.source.feed(frame(9, keyframe=True))
        await taking
        await settle()
        await feeding.rendition.source.end()
    assert feeding.taken == [9]
    said = [record.getMessage() for record in caplog.records if record.name == "openrois_streaming.feed"]
    assert len(said) == 2
    assert "camera unplugged" in said[0]


async def test_frames_of_a_former_opening_are_not_mixed_with_new_ones(feeding: Feeding) -> None:
    await feeding.rendition.source.feed(frame(1, keyframe=True))
    await feeding.rendition.source.end()
    await feeding.clock.advance(RETRY)
    taking = asyncio.create_task(feeding.take(1))
    await feeding.rendition.source.feed(frame(2), frame(50, keyframe=True))
    await taking
    assert feeding.taken == [50]


async def test_it_leaves_the_rendition_when_it_is_cancelled_while_it_enters() -> None:
    entered = asyncio.Event()

    class Slow(FedRendition):
        @asynccontextmanager
        async def subscribe(self):  # type: ignore[no-untyped-def]
            entered.set()
            await asyncio.Event().wait()
            yield

    task = asyncio.create_task(
        feed(lambda: Slow("video/VP8"), PacketTrack("video", lambda _: None), Counters(), VirtualClock())
    )
    async with asyncio.timeout(1):
        await entered.wait()
    task.cancel()
    await asyncio.wait({task})
    assert task.cancelled()
