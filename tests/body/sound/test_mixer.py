import asyncio
from collections.abc import AsyncIterator

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.sound.engine_sound import BLOCK, SEAM
from openrois_body.sound.mixer import KEPT_BLOCKS, MAX_QUEUED, BodySound, SoundBusy
from openrois_body.sound.playback import Playback
from openrois_streaming.source.source import RawAudio

from tests.support.streaming import VirtualClock, settle

START = 1000.005
"""Within block 50,000, so that 50,001 is the next."""


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock(now=START)


def constant(value: int, samples: int) -> NDArray[np.int16]:
    return np.full(samples, value, np.int16)


def play(sound: BodySound, samples: NDArray[np.int16]) -> Playback:
    """Play a whole speech."""
    playback = sound.play()
    if len(samples):
        playback.push(samples)
    playback.finish()
    return playback


def start(playback: Playback) -> float:
    moment = playback.moment(0)
    assert moment is not None
    return moment


def end(playback: Playback) -> float:
    return playback.last / 48_000


class Listener:
    """Reads an open source and keeps everything."""

    def __init__(self, blocks: AsyncIterator[RawAudio]) -> None:
        self.blocks: list[RawAudio] = []
        self._task = asyncio.create_task(self._read(blocks))

    async def _read(self, blocks: AsyncIterator[RawAudio]) -> None:
        async for block in blocks:
            self.blocks.append(block)

    @property
    def sound(self) -> NDArray[np.int16]:
        return np.concatenate([block.samples for block in self.blocks])[:, 0]

    def value_at(self, moment: float) -> int:
        """The sample that is due at `moment`."""
        index = round((moment - self.blocks[0].captured_at) * 48_000)
        return int(self.sound[index])

    async def stop(self) -> None:
        self._task.cancel()
        await asyncio.wait({self._task})


async def test_without_anything_there_is_silence_at_a_steady_pace(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        await settle()
        assert listener.blocks == []
        await clock.advance(0.016)
        assert [block.captured_at for block in listener.blocks] == [1000.02]
        await clock.advance(1.0)
        moments = [block.captured_at for block in listener.blocks]
        assert moments == pytest.approx([1000.02 + 0.02 * number for number in range(51)])
        assert not listener.sound.any()
        assert all(block.samples.shape == (BLOCK, 1) for block in listener.blocks)
        await listener.stop()


async def test_speech_starts_when_it_said_and_ends_with_its_last_sample(clock: VirtualClock) -> None:
    sound = BodySound(clock, channels=2)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        playback = play(sound, constant(5000, 4810))
        assert start(playback) == pytest.approx(1000.06)
        assert end(playback) == pytest.approx(1000.06 + 4810 / 48_000)
        await clock.advance(end(playback) - START + 0.04)
        first = round((start(playback) - listener.blocks[0].captured_at) * 48_000)
        assert listener.blocks[0].samples.shape == (BLOCK, 2)
        expected = np.zeros(len(listener.sound), np.int16)
        expected[first : first + 4810] = 5000
        faded = np.r_[first : first + SEAM, first + 4810 : first + 4810 + SEAM]
        assert np.all((listener.sound[faded] > 0) & (listener.sound[faded] < 5000))
        np.testing.assert_array_equal(np.delete(listener.sound, faded), np.delete(expected, faded))
        await listener.stop()


async def test_speeches_follow_each_other_without_a_gap(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        first, second = play(sound, constant(100, 1000)), play(sound, constant(200, 500))
        assert start(second) == end(first)
        await clock.advance(0.5)
        third = play(sound, constant(300, 100))
        assert start(third) == pytest.approx(1000.56)
        await clock.advance(0.2)
        heard = listener.sound[listener.sound > 0]
        # Each fades in while the one before it dies away.
        assert len(heard) == pytest.approx(1000 + 500 + SEAM + 100 + SEAM, abs=4)
        np.testing.assert_array_equal(heard[SEAM:1000], 100)
        np.testing.assert_array_equal(heard[1000 + SEAM : 1500], 200)
        assert np.all((heard[1000 : 1000 + SEAM] >= 100) & (heard[1000 : 1000 + SEAM] <= 200))
        await listener.stop()


async def test_speech_advances_by_the_clock_without_a_reader(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    playback = play(sound, constant(100, 48_000))
    await clock.advance(0.5)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        await clock.advance(0.7)
        assert (listener.sound == 100).sum() == pytest.approx((end(playback) - 1000.52) * 48_000, abs=4)
        await listener.stop()
    assert playback.played == 48_000


async def test_stopping_fades_within_five_milliseconds(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        playback, queued = play(sound, constant(10_000, 48_000)), play(sound, constant(7, 48_000))
        await clock.advance(0.2)
        playback.stop()
        queued.stop()
        assert (playback.is_stopped, queued.is_stopped) == (True, True)
        assert (playback.heard, queued.heard) == (round((1000.22 - start(playback)) * 48_000), 0)
        cut = 1000.22
        assert end(playback) == pytest.approx(cut + 0.005)
        playback.stop()
        await clock.advance(1.0)
        assert listener.value_at(cut - 1 / 48_000) == 10_000
        assert 4_500 < listener.value_at(cut + 0.0025) < 5_500
        assert listener.value_at(cut + 0.005) == 0
        steps = np.abs(np.diff(listener.sound.astype(int)))
        assert steps.max() <= 10_000 / SEAM + 1
        assert 7 not in listener.sound[-BLOCK:]
        await listener.stop()


async def test_stop_after_the_end_has_no_effect(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    playback = play(sound, constant(1, 480))
    await clock.advance(1)
    playback.stop()
    assert playback.heard == 480
    assert end(playback) == pytest.approx(1000.07)


async def test_stopped_speech_that_has_not_begun_is_never_heard(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        short, following = play(sound, constant(100, 2 * BLOCK + 100)), play(sound, constant(7, 1000))
        await clock.advance(start(short) - START + 0.021)
        following.stop()
        await clock.advance(1)
        assert listener.sound.max() == 100
        assert (listener.sound > 0).sum() == pytest.approx(2 * BLOCK + 100 + SEAM, abs=4)
        assert (short.heard, following.heard) == (2 * BLOCK + 100, 0)
        await listener.stop()


async def test_an_empty_speech_ends_at_once(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    playback = play(sound, constant(0, 0))
    await clock.advance(0.06)
    assert (playback.end, playback.played) == (None, 0)
    assert start(play(sound, constant(0, 10))) > end(playback)


async def test_the_queue_is_bounded_and_forgets_what_is_over(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    for _ in range(MAX_QUEUED):
        play(sound, constant(1, 480))
    with pytest.raises(SoundBusy, match="32 speeches wait already"):
        play(sound, constant(1, 480))
    await clock.advance(0.5)
    assert start(play(sound, constant(1, 480))) == pytest.approx(1000.56)


async def test_speech_and_engine_are_mixed_without_wrapping(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    sound.feed(RawAudio(np.full((9 * BLOCK, 1), 99, np.int16), 1000.02))
    async with sound.open() as blocks:
        listener = Listener(blocks)
        sound.feed(RawAudio(np.full((11 * BLOCK, 1), 20_000, np.int16), 1000.02))
        play(sound, constant(20_000, 2 * BLOCK))
        await clock.advance(0.14)
        assert [int(block.samples[-1, 0]) for block in listener.blocks] == [20_000] * 2 + [32_767] * 2 + [20_000] * 3
        assert listener.sound.min() >= 0
        assert 99 not in listener.sound
        await listener.stop()


class Ticking:
    """Feeds blocks of 20 ms whose first sample is of the moments 1000.02, 1000.04 ..., `late` seconds after these."""

    def __init__(self, clock: VirtualClock, sound: BodySound, late: float) -> None:
        self._clock, self._sound, self._late = clock, sound, late
        self._task = asyncio.create_task(self._feed())

    async def _feed(self) -> None:
        for number in range(50_001, 60_000):
            moment = number / 50
            await self._clock.sleep_until(moment + self._late)
            self._sound.feed(RawAudio(np.full((BLOCK, 1), number % 100 + 1, np.int16), moment))

    async def stop(self) -> None:
        self._task.cancel()
        await asyncio.wait({self._task})


@pytest.mark.parametrize(("late", "lag"), [(-0.03, 0.0), (0.0, 0.003), (0.05, 0.053)])
async def test_the_engine_is_heard_at_the_moments_it_says(clock: VirtualClock, late: float, lag: float) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener, engine = Listener(blocks), Ticking(clock, sound, late)
        await clock.advance(1.0)
        for moment in (1000.2, 1000.5, 1000.9):
            assert listener.value_at(moment + 0.01) == round(moment * 50) % 100 + 1
        assert sound.lag == pytest.approx(lag)
        # The last one that is there: as soon as it can be, with the time that it is of.
        newest = listener.blocks[-1].captured_at
        assert newest == pytest.approx(np.floor((clock.now() - lag) * 50) / 50)
        await engine.stop()
        await listener.stop()


async def test_speech_keeps_its_time_beside_an_engine_that_is_late(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener, engine = Listener(blocks), Ticking(clock, sound, 0.08)
        await clock.advance(0.5)
        playback = play(sound, constant(5000, 960))
        await clock.advance(0.3)
        assert listener.value_at(start(playback) - 1 / 48_000) < 200
        assert listener.value_at(start(playback) + 0.005) >= 5000
        assert listener.value_at(end(playback) - 1 / 48_000) >= 5000
        assert listener.value_at(end(playback) + 0.005) < 200
        await engine.stop()
        await listener.stop()


async def test_an_engine_that_is_late_once_is_not_waited_for_long(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        sound.feed(RawAudio(np.ones((BLOCK, 1), np.int16), 999.9))
        engine = Ticking(clock, sound, -0.03)
        await clock.advance(1.0)
        assert clock.now() - listener.blocks[-1].captured_at > 0.1
        await clock.advance(5.0)
        assert clock.now() - listener.blocks[-1].captured_at <= 0.02
        assert np.diff([block.captured_at for block in listener.blocks]) == pytest.approx(0.02)
        await engine.stop()
        await listener.stop()


async def test_a_reader_that_is_a_little_late_loses_nothing(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    playback = play(sound, constant(100, 9600))
    async with sound.open() as blocks:
        listener = Listener(blocks)
        await settle()
        clock.jump(0.2)
        await clock.advance(0.2)
        assert (listener.sound == 100).sum() == pytest.approx(9600 - SEAM, abs=4)
        assert np.diff([block.captured_at for block in listener.blocks]) == pytest.approx(0.02)
        assert end(playback) < clock.now()
        await listener.stop()


async def test_a_reader_that_is_very_late_misses_blocks_and_is_on_time_again(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        await settle()
        clock.jump(3)
        await settle()
        moments = [block.captured_at for block in listener.blocks]
        assert moments == pytest.approx([1003 - 0.02 * number for number in range(KEPT_BLOCKS, -1, -1)])
        await listener.stop()


async def test_stopping_cuts_where_a_late_reader_is(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    playback = play(sound, constant(100, 48_000))
    async with sound.open() as blocks:
        for _ in range(5):
            taking = asyncio.ensure_future(anext(blocks))
            await clock.advance(0.02)
            got = await taking
        clock.jump(0.1)
        playback.stop()
        assert got.samples[-1, 0] == 100
        assert end(playback) == pytest.approx(got.captured_at + 0.02 + 0.005)
        following = await anext(blocks)
        assert following.captured_at == pytest.approx(got.captured_at + 0.02)
        assert following.samples[0, 0] > 90
        assert not following.samples[SEAM:].any()
