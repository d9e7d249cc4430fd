import asyncio
import time
from collections.abc import AsyncIterator
from typing import TypeVar

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_streaming.clock import wall_at
from openrois_streaming.source.source import RawAudio, RawVideo
from openrois_streaming.source.stamp import read, stamped
from openrois_streaming.synthetic import ColourBars, TalkingHead, Tone

from tests.support.streaming import VirtualClock

pytestmark = pytest.mark.extra(name="streaming")

T = TypeVar("T")


async def taken(clock: VirtualClock, frames: AsyncIterator[RawVideo], seconds: float) -> list[tuple[float, RawVideo]]:
    """All frames that come within that time, each with the moment at which it came."""
    arrived: list[tuple[float, RawVideo]] = []

    async def take() -> None:
        async for frame in frames:
            arrived.append((clock.now(), frame))

    taking = asyncio.create_task(take())
    await clock.advance(seconds)
    taking.cancel()
    await asyncio.wait({taking})
    return arrived


async def next_after(clock: VirtualClock, frames: AsyncIterator[T], seconds: float) -> T:
    """Return the frame that a reader gets while that time passes."""

    async def take() -> T:
        return await anext(frames)

    taking = asyncio.create_task(take())
    await clock.advance(seconds)
    return await taking


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock(now=77_777.7, wall=1_795_000_000.25)


@pytest.mark.parametrize("fps", [15, 30, 60, 29.97])
async def test_frames_come_when_they_are_due_and_are_dated_so(clock: VirtualClock, fps: float) -> None:
    start = clock.now()
    async with ColourBars(160, 90, fps, clock=clock).open() as frames:
        arrived = await taken(clock, frames, 2.01)
    assert [frame.sequence for _, frame in arrived] == list(range(int(2.01 * fps) + 1))
    for at, frame in arrived:
        assert at == pytest.approx(start + frame.sequence / fps, abs=1e-9)
        assert frame.captured_at == pytest.approx(at, abs=1e-9)


async def test_a_late_reader_misses_frames_and_their_numbers(clock: VirtualClock) -> None:
    async with ColourBars(160, 90, 30, clock=clock).open() as frames:
        assert (await anext(frames)).sequence == 0
        clock.jump(1.01)
        late = await anext(frames)
        assert late.sequence == 30
        assert clock.now() - late.captured_at == pytest.approx(0.01)
        assert (await next_after(clock, frames, 0.025)).sequence == 31


async def test_there_is_no_drift_in_a_day(clock: VirtualClock) -> None:
    start = clock.now()
    async with ColourBars(160, 90, 29.97, clock=clock).open() as frames:
        clock.jump(86_400)
        frame = await anext(frames)
        assert frame.sequence == int(86_400 * 29.97)
        assert frame.captured_at == pytest.approx(start + frame.sequence / 29.97, abs=1e-9)


async def test_the_numbers_go_on_when_the_source_is_opened_again(clock: VirtualClock) -> None:
    bars = ColourBars(160, 90, 30, clock=clock)
    async with bars.open() as frames:
        assert (await anext(frames)).sequence == 0
    await clock.advance(10)
    async with bars.open() as frames:
        assert (await anext(frames)).sequence == 300


async def test_a_source_that_is_opened_gives_at_once_what_was_due_last(clock: VirtualClock) -> None:
    bars = ColourBars(160, 90, 30, clock=clock)
    async with bars.open() as frames:
        assert (await anext(frames)).sequence == 0
    clock.jump(1.02)
    async with bars.open() as frames:
        opened = await anext(frames)
        assert (opened.sequence, clock.now() - opened.captured_at) == (30, pytest.approx(0.02))
        assert (await next_after(clock, frames, 0.014)).sequence == 31
    async with bars.open() as frames:
        assert (await next_after(clock, frames, 0.034)).sequence == 32, "none comes twice"


async def test_nothing_is_left_sleeping_when_the_source_is_closed(clock: VirtualClock) -> None:
    async with ColourBars(160, 90, 30, clock=clock).open() as frames:
        await taken(clock, frames, 0.1)
    assert clock.sleepers == 0


def luma(frame: RawVideo) -> NDArray[np.uint8]:
    return frame.data[: frame.height]


async def test_a_white_dot_crosses_the_picture(clock: VirtualClock) -> None:
    async with ColourBars(320, 180, 30, clock=clock).open() as frames:
        arrived = await taken(clock, frames, 3.99)
    places = [float(np.mean(np.nonzero(luma(frame)[60:120] == 235)[1])) for _, frame in arrived]
    assert np.all(np.diff(places) > 0)
    assert places[0] < 15
    assert places[-1] > 305


async def test_the_picture_is_seven_bars_with_a_caption(clock: VirtualClock) -> None:
    async with ColourBars(640, 360, 30, clock=clock).open() as frames:
        first = await anext(frames)
        changed = luma(first) != luma(await next_after(clock, frames, 0.04))
    bars = luma(first)[300, 45::91].astype(int)
    assert len(bars) == 7
    assert np.all(np.diff(bars) < 0), "in the order of their luma"
    assert luma(first)[8:30, 8:400].max() > 225
    assert changed[8:40, 8:400].any(), "the caption shows the time"
    assert not changed[300:].any()


def test_caption_shows_time_and_number(clock: VirtualClock, monkeypatch: pytest.MonkeyPatch) -> None:
    bars = ColourBars(640, 360, 30, clock=clock)
    same = [bars._draw(5, wall)[8:40, 8:400] for wall in (1_795_000_000.2501, 1_795_000_000.2504)]
    assert np.array_equal(same[0], same[1])
    assert not np.array_equal(same[0], bars._draw(5, 1_795_000_000.26)[8:40, 8:400])
    assert not np.array_equal(same[0], bars._draw(6, 1_795_000_000.25)[8:40, 8:400])


def test_the_caption_is_cut_off_where_the_picture_ends(clock: VirtualClock) -> None:
    picture = ColourBars(160, 90, 30, clock=clock)._draw(12_345_678, 1_795_000_000.25)
    assert np.all(picture[8:14, 152:160] < 100), "the last bar goes on to the edge"


@pytest.mark.parametrize(
    ("width", "height", "fps"), [(158, 90, 30), (160, 88, 30), (161, 90, 30), (160, 91, 30), (160, 90, 0)]
)
def test_a_size_or_pace_that_cannot_be_is_refused(clock: VirtualClock, width: int, height: int, fps: float) -> None:
    with pytest.raises(ValueError, match="a size of 160x90 or more"):
        ColourBars(width, height, fps, clock=clock)


def test_a_picture_is_cheap_to_draw(clock: VirtualClock) -> None:
    bars = ColourBars(1280, 720, 30, clock=clock)
    started = time.thread_time()
    for number in range(30):
        bars._draw(number, clock.wall())
    assert time.thread_time() - started < 0.1, "a tenth of a core at 30 frames a second"


def lamp(frame: RawVideo) -> int:
    """Luma of the middle of the lamp."""
    return int(luma(frame)[frame.height - 30, frame.width - 20])


@pytest.mark.parametrize("make", [ColourBars, TalkingHead])
@pytest.mark.parametrize(("fps", "pictures"), [(60, 3), (30, 2), (15, 1), (10, 1)])
async def test_the_lamp_shines_at_the_begin_of_each_second(
    clock: VirtualClock, make: type[ColourBars | TalkingHead], fps: int, pictures: int
) -> None:
    async with make(320, 180, fps, clock=clock).open() as frames:
        arrived = [frame for _, frame in await taken(clock, frames, 2.0)]
    offset = wall_at(clock, 0.0)
    shining = [(frame.captured_at + offset) % 1 for frame in arrived if lamp(frame) > 200]
    assert len(shining) == pytest.approx(2 * pictures, abs=2)
    assert all(since < max(0.05, 1 / fps) + 1 / fps for since in shining)
    assert {lamp(frame) for frame in arrived} == {16, 235}
    first = min(frame.captured_at for frame in arrived if lamp(frame) > 200)
    assert (first + offset) % 1 < 1 / fps


async def test_the_lamp_is_not_in_the_way_of_the_stamp(clock: VirtualClock) -> None:
    for make in (ColourBars, TalkingHead):
        async with make(160, 90, clock=clock).open() as frames:
            first = await anext(frames)
        picture = stamped(first, clock.wall())
        found = read(luma(picture))
        assert found is not None
        assert found.number == 0


async def test_a_head_sways_and_opens_its_mouth(clock: VirtualClock) -> None:
    async with TalkingHead(320, 180, 30, clock=clock).open() as frames:
        arrived = [frame for _, frame in await taken(clock, frames, 1.99)]
    assert [frame.sequence for frame in arrived] == list(range(len(arrived)))
    assert np.array_equal(arrived[0].data, arrived[30].data), "every second is the same"
    assert not np.array_equal(arrived[0].data, arrived[10].data)
    assert not arrived[0].data.flags.writeable
    reds = [int((frame.data.reshape(-1)[320 * 180 * 5 // 4 :] == 170).sum()) for frame in arrived[:30]]
    offset = wall_at(clock, 0.0)
    widest = arrived[int(np.argmax(reds))]
    assert (widest.captured_at + offset) % 1 < 0.1


@pytest.mark.parametrize(
    ("width", "height", "fps"), [(158, 90, 30), (160, 88, 30), (161, 90, 30), (160, 91, 30), (160, 90, 0.5)]
)
def test_a_head_that_cannot_be_is_refused(clock: VirtualClock, width: int, height: int, fps: float) -> None:
    with pytest.raises(ValueError, match="a size of 160x90 or more"):
        TalkingHead(width, height, fps, clock=clock)


async def sound(clock: VirtualClock, tone: Tone, seconds: float) -> tuple[float, NDArray[np.int16]]:
    """What sounds within that time, and the wall time of its first sample."""
    blocks: list[RawAudio] = []

    async def take() -> None:
        async with tone.open() as source:
            async for block in source:
                blocks.append(block)

    wall_of_zero = wall_at(clock, 0.0)
    taking = asyncio.create_task(take())
    await clock.advance(seconds)
    taking.cancel()
    await asyncio.wait({taking})
    times = [block.captured_at for block in blocks]
    assert times == pytest.approx([times[0] + number / 50 for number in range(len(times))])
    return times[0] + wall_of_zero, np.concatenate([block.samples for block in blocks])


@pytest.mark.parametrize("channels", [1, 2])
async def test_a_burst_of_1_khz_starts_at_each_whole_second(clock: VirtualClock, channels: int) -> None:
    wall, samples = await sound(clock, Tone(channels, clock=clock), 2.5)
    assert samples.shape[1] == channels
    assert np.array_equal(samples[:, 0], samples[:, -1])
    since_second = (wall + np.arange(len(samples)) / 48_000) % 1
    assert np.all(samples[since_second > 0.0501] == 0)
    starts = np.nonzero(np.diff(since_second) < 0)[0] + 1
    assert len(starts) == 2
    for start in starts:
        burst = samples[start : start + 2400, 0].astype(float)
        assert np.argmax(np.abs(np.fft.rfft(burst))) * 48_000 / 2400 == pytest.approx(1000)
        assert np.abs(burst).max() == pytest.approx(16_000, rel=0.01)
        assert np.all(np.abs(burst[:2]) < 3000), "it starts at phase 0"


async def test_the_bursts_follow_a_step_of_the_wall_clock(clock: VirtualClock) -> None:
    tone = Tone(clock=clock)
    await sound(clock, tone, 1.0)
    clock.step_wall(0.4)
    wall, samples = await sound(clock, tone, 2.0)
    loud = np.nonzero(samples[:, 0])[0]
    assert (wall + loud[0] / 48_000) % 1 == pytest.approx(0, abs=0.0002)


async def test_a_reader_that_is_a_little_late_loses_no_sound(clock: VirtualClock) -> None:
    async with Tone(clock=clock).open() as blocks:
        first = await anext(blocks)
        clock.jump(0.2)
        times = [(await anext(blocks)).captured_at - first.captured_at for _ in range(10)]
        assert times == pytest.approx([number / 50 for number in range(1, 11)])


async def test_a_reader_that_is_very_late_loses_sound(clock: VirtualClock) -> None:
    async with Tone(clock=clock).open() as blocks:
        first = await anext(blocks)
        clock.jump(10.005)
        late = await anext(blocks)
        assert late.captured_at - first.captured_at == pytest.approx(9.8)


async def test_sound_that_is_opened_again_stays_on_its_grid(clock: VirtualClock) -> None:
    tone = Tone(clock=clock)
    async with tone.open() as blocks:
        first = await anext(blocks)
    clock.jump(1.011)
    async with tone.open() as blocks:
        again = await next_after(clock, blocks, 0.02)
        assert again.captured_at - first.captured_at == pytest.approx(1.02)


def test_a_tone_of_more_than_two_channels_is_refused(clock: VirtualClock) -> None:
    with pytest.raises(ValueError, match="1 or 2 channels, not 3"):
        Tone(3, clock=clock)
