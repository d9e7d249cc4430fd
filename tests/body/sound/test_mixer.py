import asyncio
from collections.abc import AsyncIterator

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.sound.engine_sound import BLOCK, SEAM
from openrois_body.sound.mixer import KEPT_BLOCKS, MAX_QUEUED, BodySound, SoundBusy
from openrois_streaming.source.source import RawAudio

from tests.support.streaming import VirtualClock, settle

START = 1000.005
"""Within block 50,000, so that 50,001 is the next."""


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock(now=START)


def constant(value: int, samples: int) -> NDArray[np.int16]:
    return np.full(samples, value, np.int16)


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
        playback = sound.play(constant(5000, 4810))
        assert playback.start == pytest.approx(1000.06)
        assert playback.start_ns == 1_000_060_000_000
        assert playback.end == pytest.approx(1000.06 + 4810 / 48_000)
        ended = asyncio.create_task(playback.reach(playback.end))
        await clock.advance(playback.end - START - 0.0001)
        assert not ended.done()
        await clock.advance(0.0001)
        assert await ended
        await clock.advance(0.04)
        first = round((playback.start - listener.blocks[0].captured_at) * 48_000)
        assert listener.blocks[0].samples.shape == (BLOCK, 2)
        expected = np.zeros(len(listener.sound), np.int16)
        expected[first : first + 4810] = 5000
        np.testing.assert_array_equal(listener.sound, expected)
        await listener.stop()


async def test_speeches_follow_each_other_without_a_gap(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        first, second = sound.play(constant(100, 1000)), sound.play(constant(200, 500))
        assert second.start == first.end
        await clock.advance(0.5)
        third = sound.play(constant(300, 100))
        assert third.start == pytest.approx(1000.56)
        await clock.advance(0.2)
        heard = listener.sound[listener.sound > 0]
        np.testing.assert_array_equal(heard, [100] * 1000 + [200] * 500 + [300] * 100)
        await listener.stop()


async def test_speech_advances_by_the_clock_without_a_reader(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    playback = sound.play(constant(100, 48_000))
    ended = asyncio.create_task(playback.reach(playback.end))
    await clock.advance(0.5)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        await clock.advance(0.7)
        assert (listener.sound == 100).sum() == pytest.approx((playback.end - 1000.52) * 48_000)
        await listener.stop()
    assert await ended
    assert await playback.reach(playback.end)


async def test_stopping_fades_within_five_milliseconds(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        playback, queued = sound.play(constant(10_000, 48_000)), sound.play(constant(7, 48_000))
        endings = asyncio.gather(playback.reach(playback.end), queued.reach(queued.end))
        await clock.advance(0.2)
        playback.stop()
        queued.stop()
        assert list(await endings) == [False, False]
        assert (playback.heard, queued.heard) == (round((1000.22 - playback.start) * 48_000), 0)
        cut = 1000.22
        assert playback.end == pytest.approx(cut + 0.005)
        playback.stop()
        await clock.advance(1.0)
        assert listener.value_at(cut - 1 / 48_000) == 10_000
        assert 4_500 < listener.value_at(cut + 0.0025) < 5_500
        assert listener.value_at(cut + 0.005) == 0
        steps = np.abs(np.diff(listener.sound[BLOCK * 4 :].astype(int)))
        assert steps.max() <= 10_000 / SEAM + 1
        assert 7 not in listener.sound[-BLOCK:]
        await listener.stop()


async def test_stop_after_the_end_has_no_effect(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    playback = sound.play(constant(1, 480))
    await clock.advance(1)
    playback.stop()
    assert playback.heard == 480
    assert playback.end == pytest.approx(1000.07)


async def test_stopped_speech_that_has_not_begun_is_never_heard(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    async with sound.open() as blocks:
        listener = Listener(blocks)
        short, following = sound.play(constant(100, 2 * BLOCK + 100)), sound.play(constant(7, 1000))
        await clock.advance(short.start - START + 0.021)
        following.stop()
        assert not await following.reach(following.end)
        await clock.advance(1)
        assert set(listener.sound) == {0, 100}
        assert await short.reach(short.end)
        await listener.stop()


async def test_an_empty_speech_ends_at_once(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    playback = sound.play(constant(0, 0))
    await clock.advance(0.06)
    assert await playback.reach(playback.end)
    assert sound.play(constant(0, 10)).start > playback.end


async def test_the_queue_is_bounded_and_forgets_what_is_over(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    for _ in range(MAX_QUEUED):
        sound.play(constant(1, 480))
    with pytest.raises(SoundBusy, match="32 speeches wait already"):
        sound.play(constant(1, 480))
    await clock.advance(0.5)
    assert sound.play(constant(1, 480)).start == pytest.approx(1000.56)


async def test_speech_and_engine_are_mixed_without_wrapping(clock: VirtualClock) -> None:
    sound = BodySound(clock)
    sound.feed(RawAudio(np.full((9 * BLOCK, 1), 99, np.int16), 1000.02))
    async with sound.open() as blocks:
        listener = Listener(blocks)
        sound.feed(RawAudio(np.full((11 * BLOCK, 1), 20_000, np.int16), 1000.02))
        sound.play(constant(20_000, 2 * BLOCK))
        await clock.advance(0.14)
        assert [int(block.samples[-1, 0]) for block in listener.blocks] == [20_000] * 2 + [32_767] * 2 + [20_000] * 3
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
        playback = sound.play(constant(5000, 960))
        await clock.advance(0.3)
        assert listener.value_at(playback.start - 1 / 48_000) < 200
        assert listener.value_at(playback.start) >= 5000
        assert listener.value_at(playback.end - 1 / 48_000) >= 5000
        assert listener.value_at(playback.end) < 200
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
    playback = sound.play(constant(100, 9600))
    async with sound.open() as blocks:
        listener = Listener(blocks)
        await settle()
        clock.jump(0.2)
        await clock.advance(0.2)
        assert (listener.sound == 100).sum() == 9600
        assert np.diff([block.captured_at for block in listener.blocks]) == pytest.approx(0.02)
        assert playback.end < clock.now()
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
    playback = sound.play(constant(100, 48_000))
    async with sound.open() as blocks:
        for _ in range(5):
            taking = asyncio.ensure_future(anext(blocks))
            await clock.advance(0.02)
            got = await taking
        clock.jump(0.1)
        playback.stop()
        assert got.samples[-1, 0] == 100
        assert playback.end == pytest.approx(got.captured_at + 0.02 + 0.005)
        following = await anext(blocks)
        assert following.captured_at == pytest.approx(got.captured_at + 0.02)
        assert following.samples[0, 0] > 90
        assert not following.samples[SEAM:].any()
