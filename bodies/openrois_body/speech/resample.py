"""Resampling of speech to the 48,000 Hz of all media, piece by piece. Pure.

From espeak's 22,050 Hz, 48,000 / 22,050 = 320 / 147: every 147 samples become 320. As the weights of the band-limiting
filter repeat with every such group, all groups are computed at once, as one product of matrices. From 16,000 or 24,000
Hz every sample becomes 3 or 2, and each of these is one convolution: pieces are small there, and products of small
matrices would wake threads that wait for each other.
"""

from __future__ import annotations

from functools import cache
from math import gcd
from typing import Final

import numpy as np
from numpy.typing import NDArray

SOURCE_RATE: Final = 22_050
TARGET_RATE: Final = 48_000
RATES: Final = (8_000, 11_025, 12_000, 16_000, 22_050, 24_000, 32_000, 44_100, 48_000)
"""The rates from which sound is resampled, in Hz."""
_LEAST: Final = 128
"""Least samples of a group: products of many tiny matrices would be slow."""
_REACH: Final = 32
"""Source samples to either side that a target sample depends on; 64 taps leave images 80 dB below, from 12 kHz on."""
_KAISER_BETA: Final = 9.0


class Resampler:
    """Resamples mono sound in pieces of any length, with a delay of `_REACH` samples and the rest of a group.

    A group is one sample where 48,000 is a multiple of the rate; sound of 48,000 Hz is returned as it is.

    Args:
        rate: of the sound that is added, one of `RATES`.
    """

    def __init__(self, rate: int) -> None:
        shared = gcd(rate, TARGET_RATE)
        times = 1 if rate == shared else -(-_LEAST // (rate // shared))
        self._in, self._out = times * rate // shared, times * TARGET_RATE // shared
        self._before = np.zeros(_REACH, np.float32)
        """Samples from `_REACH` before the next group on."""
        self._added = self._made = 0

    def add(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        """Return what can be computed once `samples` is known."""
        if self._in == self._out:
            return samples
        self._added += len(samples)
        return self._compute(np.concatenate((self._before, samples.astype(np.float32))))

    def finish(self) -> NDArray[np.int16]:
        """Return the rest: of n samples there are ceil(n * 48,000 / rate) in all."""
        length = -(-self._added * self._out // self._in) - self._made
        groups = -(-length // self._out)
        missing = groups * self._in + 2 * _REACH - len(self._before)
        return self._compute(np.concatenate((self._before, np.zeros(max(0, missing), np.float32))))[:length]

    def _compute(self, known: NDArray[np.float32]) -> NDArray[np.int16]:
        groups = max(0, (len(known) - 2 * _REACH) // self._in)
        self._before = known[groups * self._in :]
        self._made += groups * self._out
        if not groups:
            return np.zeros(0, np.int16)
        mixed = self._filter(known, groups)
        return np.clip(np.rint(mixed.reshape(-1)), -32768, 32767).astype(np.int16)

    def _filter(self, known: NDArray[np.float32], groups: int) -> NDArray[np.float32]:
        """Return the samples of so many groups (rows)."""
        weights = _weights(self._in, self._out)
        if self._in > 1:
            windows = np.lib.stride_tricks.sliding_window_view(known, self._in + 2 * _REACH)[:: self._in][:groups]
            return np.asarray(windows @ weights, np.float32)
        mixed = np.empty((groups, self._out), np.float32)
        for phase, each in enumerate(weights.T):
            mixed[:, phase] = np.convolve(known, each[::-1], "valid")[:groups]
        return mixed


@cache
def _weights(group: int, made: int) -> NDArray[np.float32]:
    """Return the weight of each source sample around a group (rows) in each of its target samples (columns)."""
    source = np.arange(group + 2 * _REACH)[:, None] - _REACH
    target = np.arange(made)[None, :] * group / made
    distance = source - target
    window = np.i0(_KAISER_BETA * np.sqrt(np.clip(1 - (distance / _REACH) ** 2, 0, None))) / np.i0(_KAISER_BETA)
    weights = np.where(np.abs(distance) < _REACH, np.sinc(distance) * window, 0)
    return np.asarray(weights / weights.sum(axis=0), np.float32)
