"""What viewers get over bad networks: behaviour, not times."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from openrois_streaming.adaptation.budget import START
from openrois_streaming.clock import SystemClock
from openrois_streaming.publish.publisher import VideoPublisher
from openrois_streaming.testing import ImpairedPath, Impairments, MeasuringSink, playing
from openrois_streaming.testing.plugin import MakePath, MakeSink, MakeSource
from openrois_streaming.testing.stage import VIDEO

pytestmark = pytest.mark.media

BACK = Impairments(delay=0.01)


@pytest.fixture
def video(synthetic_source: MakeSource) -> VideoPublisher:
    return VideoPublisher(synthetic_source("bars", 320, 180), clock=SystemClock(), stamp=True)


@asynccontextmanager
async def seen_over(path: ImpairedPath, make_sink: MakeSink, video: VideoPublisher) -> AsyncIterator[MeasuringSink]:
    """A sink that has seen some pictures over `path` and begins to count."""
    async with path, make_sink(path=path) as sink, playing(sink, video=video):
        await sink.sees(10)
        sink.restart()
        yield sink


async def test_losses_are_repaired(impaired_path: MakePath, measuring_sink: MakeSink, video: VideoPublisher) -> None:
    path = impaired_path(Impairments(loss=0.05, delay=0.01), BACK)
    async with seen_over(path, measuring_sink, video) as sink:
        await sink.sees(60)
        assert path.down.figures().lost > 0
        assert sink.received("0").nacks > 0
        assert sink.pictures().unreadable == sink.pictures().repeated == 0
        assert sink.pictures().key_frames <= 2


async def test_a_burst_costs_few_key_frames(
    impaired_path: MakePath, measuring_sink: MakeSink, video: VideoPublisher
) -> None:
    path = impaired_path(Impairments(delay=0.01), BACK)
    async with seen_over(path, measuring_sink, video) as sink:
        path.down.lose_next(40)
        await sink.sees(30)
        assert path.down.figures().lost == 40
        assert sink.pictures().unreadable == 0
        assert sink.pictures().key_frames <= 2


async def test_disorder_does_no_harm(impaired_path: MakePath, measuring_sink: MakeSink, video: VideoPublisher) -> None:
    path = impaired_path(Impairments(delay=0.01, reorder=0.1, reorder_by=0.015, duplicate=0.1), BACK)
    async with seen_over(path, measuring_sink, video) as sink:
        await sink.sees(30)
        figures = path.down.figures()
        assert figures.held_back > 0
        assert figures.duplicated > 0
        assert sink.pictures().unreadable == sink.pictures().repeated == 0
        assert sink.received("0").key_frame_requests == sink.pictures().key_frames == 0


async def test_a_slow_viewer_gets_less_and_the_fast_one_all(
    impaired_path: MakePath, measuring_sink: MakeSink, synthetic_source: MakeSource
) -> None:
    clock = SystemClock()
    head = VideoPublisher(synthetic_source("head", 640, 360), clock=clock, stamp=True, size=(640, 360))
    async with (
        impaired_path(Impairments(rate=400_000, delay=0.01), BACK) as path,
        measuring_sink() as fast,
        measuring_sink(path=path) as slow,
        playing(fast, video=head),
        playing(slow, video=head),
    ):
        await fast.sees(10)
        await slow.until(lambda: slow.states and slow.received("0").packets and slow.pictures().size == (320, 180))
        while True:
            await fast.until(lambda: fast.pictures().size == (640, 360))
            fast.restart()
            slow.restart()
            await slow.sees(30)
            # A busy machine slows the fast one down for a while, too.
            if (fast.pictures().size, fast.pictures().size_changes) == ((640, 360), 0):
                break
        assert fast.pictures().key_frames <= 1
        for seen in (fast.pictures(), slow.pictures()):
            assert seen.unreadable == seen.repeated == 0


async def test_a_path_that_is_long_is_found_to_carry_more_than_was_thought(
    impaired_path: MakePath, measuring_sink: MakeSink, synthetic_source: MakeSource
) -> None:
    bars = synthetic_source("bars", 1280, 720)
    video = VideoPublisher(bars, clock=SystemClock(), stamp=True, size=(1280, 720))
    far = Impairments(delay=0.35, jitter=0.03)
    async with (
        impaired_path(far, far) as path,
        measuring_sink(path=path) as sink,
        playing(sink, video=video) as session,
    ):
        while (adaptation := (await session.stats(VIDEO)).adaptation) is None or adaptation.path <= START:
            await sink.sees(5)
        assert sink.pictures().unreadable == 0
