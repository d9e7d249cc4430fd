"""Silence, with a marker at each whole second."""

import math
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager

import numpy as np
from numpy.typing import NDArray

from openrois_streaming.clock import MediaClock, wall_at
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio
from openrois_streaming.synthetic.marks import MARKER_HZ, MARKER_SECONDS
from openrois_streaming.synthetic.pacing import due

BLOCK_SAMPLES = SAMPLE_RATE // 50

_AMPLITUDE = 16_000
# A sound card keeps this much for a reader that is late; with 20 ms a block it is 0.2 s.
_KEPT_BLOCKS = 10


class Tone:
    """Silence, with a burst of 1 kHz and 50 ms at each whole second of wall time.

    Blocks of 20 ms come when the moment of their first sample has come, without drift; a reader that is late by up to
    0.2 s loses nothing, one that is later misses blocks. When the wall clock is stepped, the bursts follow.

    Args:
        channels: 1 or 2, all the same.
        clock: by which the blocks are paced and dated.
    """

    def __init__(self, channels: int = 1, *, clock: MediaClock) -> None:
        if channels not in (1, 2):
            raise ValueError(f"a tone has 1 or 2 channels, not {channels}")
        self.channels = channels
        self._clock = clock
        self._epoch: float | None = None

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawAudio]]:
        """Yield the iterator of blocks; it does not end."""
        if self._epoch is None:
            self._epoch = self._clock.now()
        async with aclosing(self._blocks(self._epoch)) as blocks:
            yield blocks

    async def _blocks(self, epoch: float) -> AsyncGenerator[RawAudio, None]:
        offset = wall_at(self._clock, 0.0)
        async for number in due(self._clock, epoch, SAMPLE_RATE / BLOCK_SAMPLES, patience=_KEPT_BLOCKS):
            moment = epoch + number * BLOCK_SAMPLES / SAMPLE_RATE
            if MARKER_SECONDS < (moment + offset) % 1 < 0.9:
                # Read anew only between the bursts: a reading that is off by a delay must not tear one.
                offset = wall_at(self._clock, 0.0)
            yield RawAudio(np.repeat(_marker(moment + offset)[:, np.newaxis], self.channels, axis=1), moment)


def _marker(wall: float) -> NDArray[np.int16]:
    """The block whose first sample is at `wall`."""
    since_second = (wall % 1 + np.arange(BLOCK_SAMPLES) / SAMPLE_RATE) % 1
    wave = _AMPLITUDE * np.sin(2 * math.pi * MARKER_HZ * since_second)
    return np.where(since_second < MARKER_SECONDS, wave, 0).astype(np.int16)
