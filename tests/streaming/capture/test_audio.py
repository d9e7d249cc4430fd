"""Sound of microphones: shapes, moments, and other rates."""

import re
from collections.abc import AsyncIterator, Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_streaming.capture.audio import AudioSource, Sound
from openrois_streaming.publish.audio_encoder import OpusEncoder
from openrois_streaming.source.source import RawAudio
from openrois_streaming.synthetic import Tone

from tests.support.streaming import VirtualClock


def microphone(*blocks: Any, sample_rate: int = 48_000) -> AudioSource:
    def given() -> Iterator[Sound]:
        yield from blocks

    return AudioSource(given, sample_rate=sample_rate, clock=VirtualClock(), name="the mast")


async def taken(source: AudioSource) -> list[RawAudio]:
    async with source.open() as blocks:
        return [block async for block in blocks]


def tone(rate: int, seconds: float, channels: int = 1) -> NDArray[np.int16]:
    wave = 8000 * np.sin(2 * np.pi * 440 * np.arange(round(rate * seconds)) / rate)
    return np.repeat(wave.astype(np.int16)[:, np.newaxis], channels, axis=1)


@pytest.mark.parametrize("shape", [(480,), (480, 1), (480, 2)])
async def test_blocks_have_one_or_two_channels(shape: tuple[int, ...]) -> None:
    (block,) = await taken(microphone(np.ones(shape, np.int16)))
    assert block.samples.shape == (480, *(shape[1:] or (1,)))


async def test_a_block_began_before_it_came_unless_its_moment_is_given() -> None:
    silence = np.zeros(4800, np.int16)
    first, second = await taken(microphone(silence, (silence, 999.5)))
    assert first.captured_at == pytest.approx(1000 - 0.1)
    assert second.captured_at == 999.5


async def test_blocks_that_come_several_at_once_follow_each_other() -> None:
    clock = VirtualClock()

    async def bursts() -> AsyncIterator[Sound]:
        for _ in range(20):
            await clock.advance(0.12)  # as many programs write: twelve blocks of 10 ms after 120 ms
            for _ in range(12):
                yield np.zeros(480, np.int16)

    blocks = await taken(AudioSource(bursts, clock=clock))
    moments = [block.captured_at for block in blocks]
    assert moments[12:] == pytest.approx([1000 + number / 100 for number in range(12, 240)])
    encoder = OpusEncoder(bitrate=64_000)
    packets = [chunk.pts for block in blocks for chunk in encoder.encode(block, key_frame=False)]
    assert len(packets) >= 114, "of 120, all are sent but those of the first burst"
    assert set(np.diff(packets)) == {960}


async def test_sound_that_was_lost_leaves_a_gap() -> None:
    clock = VirtualClock()

    async def interrupted() -> AsyncIterator[Sound]:
        for number in range(120):
            await clock.advance(0.55 if number == 20 else 0.05)
            yield np.zeros(2400, np.int16)

    moments = [block.captured_at for block in await taken(AudioSource(interrupted, clock=clock))]
    assert moments[19] == pytest.approx(1000.95)
    assert moments[119] == pytest.approx(1006.45)


async def test_after_a_pause_the_moments_begin_anew() -> None:
    clock = VirtualClock()

    async def paused() -> AsyncIterator[Sound]:
        for number in range(3):
            await clock.advance(60.0 if number == 2 else 0.05)
            yield np.zeros(2400, np.int16)

    moments = [block.captured_at for block in await taken(AudioSource(paused, clock=clock))]
    assert moments == pytest.approx([1000.0, 1000.05, 1060.05])


@pytest.mark.parametrize("rate", [8_000, 16_000, 44_100, 96_000])
@pytest.mark.parametrize("channels", [1, 2])
async def test_another_rate_becomes_48000_and_stays_the_same_tone(rate: int, channels: int) -> None:
    sound = tone(rate, 1.0, channels)
    blocks = [sound[at : at + rate // 50] for at in range(0, len(sound), rate // 50)]
    made = await taken(microphone(*blocks, sample_rate=rate))
    samples = np.concatenate([block.samples for block in made])
    assert samples.shape[1] == channels
    assert len(samples) == pytest.approx(48_000, rel=0.02)
    spectrum = np.abs(np.fft.rfft(samples[4800:43200, 0].astype(float)))
    loudest = np.argmax(spectrum) * 48_000 / 38_400
    assert loudest == pytest.approx(440, abs=2)
    assert np.abs(samples).max() == pytest.approx(8000, rel=0.05)


async def test_a_media_source_is_taken_as_it_is() -> None:
    async with AudioSource(Tone(clock=VirtualClock())).open() as blocks:
        assert (await anext(blocks)).samples.shape[1] in (1, 2)


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        (np.zeros(480, np.float32), TypeError, "as int16 arrays, not float32: scale floats by 32767 first"),
        (b"\0\0", TypeError, "not bytes"),
        (np.zeros((480, 3), np.int16), ValueError, "(n,), (n, 1) or (n, 2), not (480, 3)"),
        (np.zeros((2, 480, 1), np.int16), ValueError, "not (2, 480, 1)"),
    ],
)
async def test_what_is_no_sound_is_refused(wrong: Any, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=re.escape(text)):
        await taken(microphone(wrong))


@pytest.mark.parametrize("rate", [0, 7_999, 192_001])
def test_a_rate_out_of_range_is_refused(rate: int) -> None:
    with pytest.raises(ValueError, match=f"must be 8000 to 192000, not {rate}"):
        AudioSource(lambda: iter([]), sample_rate=rate)


def test_an_iterator_in_place_of_its_function_is_refused_at_once() -> None:
    with pytest.raises(TypeError, match=r"microphone must be a function that returns an iterator, not a .*: do not"):
        AudioSource(iter([]))  # type: ignore[arg-type]


@pytest.mark.parametrize("rate", ["48000", 44_100.5])
def test_a_rate_that_is_no_whole_number_is_refused(rate: Any) -> None:
    with pytest.raises(ValueError, match=f"must be 8000 to 192000, not {rate}"):
        AudioSource(lambda: iter([]), sample_rate=rate)
