import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from random import Random

import pytest
from openrois_streaming.encoded import EncodedFrame
from openrois_streaming.publish.key_frames import KeyFrameBudget, KeyFrameCause
from openrois_streaming.publish.rendition_feed import FIRST_RETRY, RETRY, STILL_INTERVAL, STILL_LEAST, RenditionFeed
from openrois_streaming.stats import Counters
from openrois_streaming.tasks import OwnedTasks

from tests.support.streaming import VirtualClock, settle
from tests.support.viewing import FedRendition, frame


class Feeding:
    """A feed from a rendition to a sender, and the sequences that this was given."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.counters = Counters()
        self.taken: list[int] = []
        self.times: list[int] = []
        self.rendition = FedRendition("video/VP8")
        self.tasks = OwnedTasks("test", lambda error: pytest.fail(repr(error)))
        self.feed = RenditionFeed("video", self.send, self.counters, self.tasks, self.clock)

    def send(self, each: EncodedFrame) -> None:
        self.taken.append(each.sequence)
        self.times.append(each.pts)


@pytest.fixture
async def feeding() -> AsyncIterator[Feeding]:
    feeding = Feeding()
    feeding.feed.play(feeding.rendition)
    await settle()
    yield feeding
    feeding.feed.close()
    await feeding.tasks.aclose()
    assert feeding.rendition.readers == feeding.rendition.wants == 0


async def test_frames_reach_the_sender_from_a_key_frame_on(feeding: Feeding) -> None:
    assert feeding.rendition.asked == [KeyFrameCause.START]
    await feeding.rendition.source.feed(frame(4), frame(5, keyframe=True), frame(6))
    assert feeding.taken == [5, 6]
    assert feeding.counters.frames_dropped == 0


async def test_a_gap_asks_for_a_repair_and_sends_nothing_that_cannot_be_decoded(feeding: Feeding) -> None:
    await feeding.rendition.source.feed(frame(1, keyframe=True), frame(2), frame(4), frame(5), frame(6, keyframe=True))
    assert feeding.taken == [1, 2, 6]
    assert feeding.rendition.asked == [KeyFrameCause.START, KeyFrameCause.REPAIR]
    assert feeding.counters.frames_dropped == 2


async def test_a_source_that_fails_is_tried_again_and_said_once(
    feeding: Feeding, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING, logger="openrois_streaming.publish.rendition_feed"):
        await feeding.rendition.source.end(OSError("camera unplugged"))
        feeding.rendition.source.refusal = OSError("no camera")
        for seconds in (FIRST_RETRY, RETRY, RETRY):
            assert (feeding.rendition.readers, feeding.rendition.wants) == (0, 1)
            await feeding.clock.advance(seconds)
        feeding.rendition.source.refusal = None
        await feeding.clock.advance(RETRY)
        await feeding.rendition.source.feed(frame(9, keyframe=True))
        await settle()
        await feeding.rendition.source.end()
    assert feeding.taken == [9]
    said = [
        record.getMessage() for record in caplog.records if record.name == "openrois_streaming.publish.rendition_feed"
    ]
    assert len(said) == 2
    assert "camera unplugged" in said[0]


async def test_after_each_failure_the_first_try_comes_soon_and_the_next_ones_later(feeding: Feeding) -> None:
    for number in (1, 2):
        await feeding.rendition.source.feed(frame(number, keyframe=True))
        await feeding.rendition.source.end(OSError("no such codec"))
        await feeding.clock.advance(FIRST_RETRY)
        assert feeding.rendition.readers == 1
    await feeding.rendition.source.end(OSError("no such codec"))
    await feeding.clock.advance(RETRY - 0.1)
    assert feeding.rendition.readers == 0, "no frame has come since it was opened last"
    await feeding.clock.advance(0.2)
    assert feeding.rendition.readers == 1


async def test_frames_of_a_former_opening_are_not_mixed_with_new_ones(feeding: Feeding) -> None:
    await feeding.rendition.source.feed(frame(1, keyframe=True))
    await feeding.rendition.source.end()
    await feeding.clock.advance(RETRY)
    await feeding.rendition.source.feed(frame(2), frame(50, keyframe=True))
    assert feeding.taken == [1, 50]


async def test_another_rendition_begins_with_its_key_frame_and_until_then_the_present_one_goes_on(
    feeding: Feeding,
) -> None:
    other = FedRendition("video/VP8")
    await feeding.rendition.source.feed(frame(1, keyframe=True), frame(2))
    feeding.feed.play(other, 500_000)
    feeding.feed.play(other, 600_000)
    await settle()
    assert (other.readers, other.asked, other.demanded) == (1, [KeyFrameCause.START], 600_000)
    await other.source.feed(frame(102, at=3 / 30))
    await feeding.rendition.source.feed(frame(3))
    await other.source.feed(frame(103, keyframe=True, at=4 / 30))
    await settle()
    assert feeding.rendition.readers == 0
    await other.source.feed(frame(104, at=5 / 30))
    assert feeding.taken == [1, 2, 3, 103, 104]
    assert feeding.times == [frame(number).pts for number in (1, 2, 3, 4, 5)]
    assert feeding.feed.rendition is other
    assert feeding.counters.frames_dropped == 0


async def test_times_grow_also_when_the_other_rendition_is_behind(feeding: Feeding) -> None:
    other = FedRendition("video/VP8")
    await feeding.rendition.source.feed(frame(5, keyframe=True))
    feeding.feed.play(other)
    await settle()
    await feeding.rendition.source.feed(frame(6))
    await other.source.feed(frame(105, keyframe=True, at=5 / 30), frame(106, at=6 / 30), frame(107, at=7 / 30))
    assert feeding.taken == [5, 6, 105, 106, 107]
    assert feeding.times == [15_000, 18_000, 18_001, 18_002, 21_000]


async def test_a_change_can_be_called_off_and_another_one_made_in_its_place(feeding: Feeding) -> None:
    second, third = FedRendition("video/VP8"), FedRendition("video/VP8")
    await feeding.rendition.source.feed(frame(1, keyframe=True))
    for each in (second, third):
        feeding.feed.play(each)
        await settle()
    assert (second.readers, third.readers) == (0, 1)
    feeding.feed.play(feeding.rendition)
    await settle()
    assert (feeding.rendition.readers, third.readers) == (1, 0)
    await feeding.rendition.source.feed(frame(2))
    assert feeding.taken == [1, 2]


async def test_a_repair_is_asked_of_what_is_played(feeding: Feeding) -> None:
    feeding.feed.repair()
    await feeding.rendition.source.feed(frame(1, keyframe=True))
    feeding.feed.repair()
    assert feeding.rendition.asked == [KeyFrameCause.START, KeyFrameCause.REPAIR]


async def test_stills_are_key_frames_and_not_many(feeding: Feeding) -> None:
    await feeding.rendition.source.feed(frame(0, keyframe=True))
    feeding.feed.stills = True
    shown = [frame(number, keyframe=number in (20, 61, 62, 130)) for number in range(1, 131)]
    await feeding.rendition.source.feed(*shown)
    assert feeding.taken == [0, 61, 130]
    assert feeding.rendition.asked[1:2] == [KeyFrameCause.STILL]
    feeding.feed.stills = False
    await feeding.rendition.source.feed(frame(131), frame(133), frame(134, keyframe=True))
    assert feeding.taken == [0, 61, 130, 131, 134]


async def test_a_repair_among_stills_is_the_next_key_frame_also_when_they_end_before_it(feeding: Feeding) -> None:
    await feeding.rendition.source.feed(frame(0, keyframe=True))
    feeding.feed.stills = True
    feeding.feed.repair()
    assert feeding.rendition.asked == [KeyFrameCause.START]
    feeding.feed.stills = False
    await feeding.rendition.source.feed(frame(1), frame(2, keyframe=True), frame(3))
    assert feeding.taken == [0, 2, 3]
    assert feeding.rendition.asked == [KeyFrameCause.START, KeyFrameCause.REPAIR]


@pytest.mark.parametrize("rate", [15, 30])
@pytest.mark.parametrize("whose", ["its own", "another's"])
@pytest.mark.parametrize("after", [0.2, 0.95, 1.4])
async def test_stills_keep_their_interval_beside_other_key_frame_requests(
    feeding: Feeding, rate: int, whose: str, after: float
) -> None:
    """Some viewer of the rendition asks so many seconds after each key frame, and then again five times a second."""
    budget, key_at, shown_at, asked_at, gaps = KeyFrameBudget(), 0.0, 0.0, 0.0, []
    await feeding.rendition.source.feed(frame(0, keyframe=True, at=0.0))
    feeding.feed.stills = True
    for number in range(1, 20 * rate):
        now = number / rate
        if now - key_at >= after and now - asked_at >= 0.2:
            asked_at = now
            if whose == "its own":
                feeding.feed.repair()
            else:
                feeding.rendition.request_key_frame(KeyFrameCause.REPAIR)
        while feeding.rendition.asked:
            budget.request(feeding.rendition.asked.pop())
        keyframe = budget.take_cause(now) is not None
        await feeding.rendition.source.feed(frame(number, keyframe=keyframe, at=now))
        if keyframe:
            key_at = now
            budget.served()
        if feeding.taken[-1] == number:
            gaps.append(now - shown_at)
            shown_at = now
    assert max(gaps[1:]) < STILL_INTERVAL + 0.2
    assert min(gaps) > 0.8


@pytest.mark.parametrize("seed", range(12))
async def test_stills_come_in_time_where_viewers_join_and_lose_data_at_once(feeding: Feeding, seed: int) -> None:
    chance, rate, budget, shown_at, gaps = Random(seed), 30, KeyFrameBudget(), 0.0, []
    joins, losses = chance.choice((0.3, 0.7, 1.1)), chance.choice((0.2, 1.0, 3.0))
    await feeding.rendition.source.feed(frame(0, keyframe=True, at=0.0))
    feeding.feed.stills = True
    for number in range(1, 60 * rate):
        now = number / rate
        for cause, often in ((KeyFrameCause.START, joins), (KeyFrameCause.REPAIR, losses)):
            if chance.random() < often / rate:
                budget.request(cause)
        while feeding.rendition.asked:
            budget.request(feeding.rendition.asked.pop())
        keyframe = budget.take_cause(now) is not None
        await feeding.rendition.source.feed(frame(number, keyframe=keyframe, at=now))
        if keyframe:
            budget.served()
        if feeding.taken[-1] == number:
            gaps.append(now - shown_at)
            shown_at = now
    # It is asked for with one picture, and may be the one after the next.
    assert max(gaps) < STILL_INTERVAL + 3 / rate
    assert min(gaps) >= STILL_LEAST - 0.001


async def test_feed_closed_while_joining_leaves_the_rendition() -> None:
    entered = asyncio.Event()

    class Slow(FedRendition):
        @asynccontextmanager
        async def play(self, *_: object):  # type: ignore[no-untyped-def]
            entered.set()
            await asyncio.Event().wait()
            yield

    feeding = Feeding()
    feeding.feed.play(Slow("video/VP8"))
    async with asyncio.timeout(60):
        await entered.wait()
    feeding.feed.close()
    await feeding.tasks.aclose()
