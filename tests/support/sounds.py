"""Sounds that are known, and sources that make them."""

import itertools
from collections.abc import AsyncIterator, Callable

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import SystemClock
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio


def bursts(*starts: int, length: int = 2 * SAMPLE_RATE, amplitude: int = 16_000) -> NDArray[np.int16]:
    """Silence with a burst of 1 kHz and 50 ms at each of these samples, as `synthetic.Tone` has them."""
    sound = np.zeros(length, np.int16)
    wave = amplitude * np.sin(2 * np.pi * 1000 * np.arange(SAMPLE_RATE // 20) / SAMPLE_RATE)
    for start in starts:
        sound[start : start + len(wave)] = wave[: length - start]
    return sound


def tone(seconds: float, rate: int, pitch: float = 300) -> NDArray[np.int16]:
    """Return a tone, mono."""
    wave = np.sin(2 * np.pi * pitch * np.arange(round(seconds * rate)) / rate)
    return np.asarray(wave * 16_000, np.int16)


async def paced(block: Callable[[int], NDArray[np.int16]]) -> AsyncIterator[RawAudio]:
    """Yield blocks of 20 ms by their numbers, each at its time: the sound of a microphone."""
    clock = SystemClock()
    began = clock.now()
    for number in itertools.count():
        due = began + number * 0.02
        await clock.sleep_until(due)
        yield RawAudio(block(number), due)
