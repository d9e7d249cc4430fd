import itertools

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_avatar.jitter import BLOCK, LIMIT_BLOCKS, SEAM, TARGET_BLOCKS, JitterBuffer


class Tone:
    """A steady tone: whatever was left out or repeated shows as a jump between two samples."""

    def __init__(self, channels: int = 1) -> None:
        self._channels = channels
        self._position = 0

    def take(self, count: int = BLOCK) -> NDArray[np.int16]:
        moments = np.arange(self._position, self._position + count)
        self._position += count
        wave = np.round(10_000 * np.sin(2 * np.pi * 200 * moments / 48_000)).astype(np.int16)
        return np.repeat(wave[:, np.newaxis], self._channels, axis=1)


# The steepest step of the tone, and what a cross-fade of 5 ms adds to it at most.
SMOOTH = 10_000 * 2 * np.pi * 200 / 48_000 + 20_000 / SEAM


def steepest(sound: NDArray[np.int16]) -> int:
    return int(np.abs(np.diff(sound[:, 0].astype(int))).max())


def filled() -> tuple[JitterBuffer, Tone]:
    buffer, tone = JitterBuffer(1), Tone()
    for _ in range(TARGET_BLOCKS):
        buffer.put(tone.take())
    return buffer, tone


def test_there_is_silence_until_enough_is_there() -> None:
    buffer, tone = JitterBuffer(1), Tone()
    for _ in range(TARGET_BLOCKS - 1):
        buffer.put(tone.take())
        assert not buffer.take().any()
    buffer.put(tone.take())
    first = buffer.take()
    assert first.shape == (BLOCK, 1)
    assert first.dtype == np.int16
    np.testing.assert_array_equal(first[SEAM:], Tone().take()[SEAM:])
    assert np.abs(first[:10]).max() < 500


def test_a_steady_engine_is_passed_on_sample_by_sample() -> None:
    buffer, tone = filled()
    sounds = []
    for _ in range(200):
        sounds.append(buffer.take())
        buffer.put(tone.take())
    np.testing.assert_array_equal(np.concatenate(sounds)[SEAM:], Tone().take(200 * BLOCK)[SEAM:])
    assert buffer.repeated == buffer.left_out == buffer.overflowed == 0


@pytest.mark.parametrize("sizes", [[1600], [BLOCK, 0, 2 * BLOCK, 0, 2 * BLOCK], [441, 519]])
def test_bursts_and_odd_sizes_are_evened_out(sizes: list[int]) -> None:
    buffer, tone = filled()
    sounds, produced, given = [], 0, itertools.cycle(sizes)
    for number in range(300):
        while produced <= number * BLOCK:
            size = next(given)
            produced += size
            if size:
                buffer.put(tone.take(size))
            else:
                break
        sounds.append(buffer.take())
    sound = np.concatenate(sounds)
    assert steepest(sound) < SMOOTH
    assert buffer.repeated + buffer.left_out < 3


@pytest.mark.parametrize(("speed", "counter"), [(1.01, "left_out"), (0.99, "repeated")])
def test_drift_costs_a_block_now_and_then_and_nobody_hears_a_click(speed: float, counter: str) -> None:
    buffer, tone = filled()
    sounds, owed = [], 0.0
    for _ in range(1500):
        owed += BLOCK * speed
        buffer.put(tone.take(int(owed)))
        owed -= int(owed)
        sounds.append(buffer.take())
    sound = np.concatenate(sounds)
    assert steepest(sound) < SMOOTH
    assert 8 <= getattr(buffer, counter) <= 16
    assert buffer.repeated + buffer.left_out == getattr(buffer, counter)
    assert buffer.overflowed == 0
    loudness = np.abs(sound[BLOCK:].reshape(-1, BLOCK).astype(int)).max(axis=1)
    assert loudness.min() > 9_000


def test_an_engine_that_stops_fades_out_and_comes_back() -> None:
    buffer, tone = filled()
    sounds = [buffer.take() for _ in range(10)]
    assert [bool(sound[SEAM:].any()) for sound in sounds] == [True] * 4 + [False] * 6
    for _ in range(TARGET_BLOCKS):
        buffer.put(tone.take())
    sounds.append(buffer.take())
    assert sounds[-1].any()
    assert steepest(np.concatenate(sounds)) < SMOOTH
    assert buffer.repeated == 1


def test_what_is_too_much_is_cut_to_the_target() -> None:
    buffer, tone = filled()
    sounds = [buffer.take()]
    buffer.put(tone.take(20 * BLOCK))
    assert buffer.overflowed == 20 - 1
    sounds += [buffer.take() for _ in range(TARGET_BLOCKS)]
    assert steepest(np.concatenate(sounds)) < SMOOTH
    np.testing.assert_array_equal(sounds[-1], Tone().take((TARGET_BLOCKS + 20) * BLOCK)[-BLOCK:])
    assert LIMIT_BLOCKS > TARGET_BLOCKS


def test_clearing_begins_anew() -> None:
    buffer, tone = filled()
    buffer.take()
    buffer.clear()
    buffer.put(tone.take())
    assert not buffer.take().any()


def test_channels_are_mixed_down_or_doubled() -> None:
    mono, stereo = JitterBuffer(1), JitterBuffer(2)
    left_right = np.tile(np.array([[30_000, 32_000]], np.int16), (BLOCK, 1))
    for _ in range(TARGET_BLOCKS):
        mono.put(left_right)
        stereo.put(left_right[:, :1])
    assert mono.take()[-1].tolist() == [31_000]
    assert stereo.take()[-1].tolist() == [30_000, 30_000]
