"""Resampling to the 48,000 Hz of all media: whole from espeak's 22,050 Hz, and piece by piece from a part of it. Pure.

48,000 / 22,050 = 320 / 147: every 147 samples become 320. As the weights of the band-limiting filter repeat with every
such group, all groups are computed at once, as one product of matrices. From 16,000 or 24,000 Hz every sample becomes 3
or 2, and each of these is one convolution: products of small matrices would wake threads that wait for each other.
"""

from __future__ import annotations

from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

SOURCE_RATE: Final = 22_050
TARGET_RATE: Final = 48_000
_IN: Final = 147
_OUT: Final = 320
_REACH: Final = 32
"""Source samples to either side that a target sample depends on; 64 taps leave images 80 dB below, from 12 kHz on."""
_KAISER_BETA: Final = 9.0


def to_48k(samples: NDArray[np.int16]) -> NDArray[np.int16]:
    """Resample mono sound; n samples become ceil(n * 320 / 147)."""
    length = -(-len(samples) * _OUT // _IN)
    groups = max(1, -(-length // _OUT))
    padded = np.zeros(groups * _IN + 2 * _REACH, np.float32)
    padded[_REACH : _REACH + len(samples)] = samples
    windows = np.lib.stride_tricks.sliding_window_view(padded, _IN + 2 * _REACH)[::_IN]
    mixed: NDArray[np.float32] = (windows @ _weights(_IN, _OUT)).reshape(-1)[:length]
    return np.clip(np.rint(mixed), -32768, 32767).astype(np.int16)


class Upsampler:
    """Resamples one stream of mono sound, piece by piece: n samples become exactly as many times as many.

    What comes out is 32 source samples late (2 ms of 16,000 Hz) until `finish`.

    Args:
        factor: samples that each sample becomes.
    """

    def __init__(self, factor: int) -> None:
        self._factor = factor
        self._kept = np.zeros(_REACH, np.float32)

    def push(self, samples: NDArray[np.int16]) -> NDArray[np.int16]:
        """Return the next samples."""
        if self._factor == 1:
            return samples
        around = np.concatenate((self._kept, samples.astype(np.float32)))
        count = len(around) - 2 * _REACH
        if count <= 0:
            self._kept = around
            return np.zeros(0, np.int16)
        self._kept = around[count:]
        mixed = np.empty((count, self._factor), np.float32)
        for phase, weights in enumerate(_weights(1, self._factor).T):
            mixed[:, phase] = np.convolve(around, weights[::-1], "valid")[:count]
        return np.clip(np.rint(mixed.reshape(-1)), -32768, 32767).astype(np.int16)

    def finish(self) -> NDArray[np.int16]:
        """Return the samples that are left, as if silence followed."""
        return self.push(np.zeros(_REACH, np.int16)) if self._factor > 1 else np.zeros(0, np.int16)


@cache
def _weights(group: int, becomes: int) -> NDArray[np.float32]:
    """Return the weight of each source sample around a group (rows) in each of its target samples (columns)."""
    source = np.arange(group + 2 * _REACH)[:, None] - _REACH
    target = np.arange(becomes)[None, :] * group / becomes
    distance = source - target
    window = np.i0(_KAISER_BETA * np.sqrt(np.clip(1 - (distance / _REACH) ** 2, 0, None))) / np.i0(_KAISER_BETA)
    weights = np.where(np.abs(distance) < _REACH, np.sinc(distance) * window, 0)
    return np.asarray(weights / weights.sum(axis=0), np.float32)
