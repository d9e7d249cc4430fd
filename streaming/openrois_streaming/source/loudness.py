"""Loudness of sound, in dBFS. Pure."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

FLOOR: Final = -100.0
"""dBFS of silence, below the smallest step of 16 bits (-90.3)."""
_FULL_SCALE: Final = 32_768.0


class Level(NamedTuple):
    """Root mean square and greatest value, in dB of full scale: a sine that just fits has -3.0 and 0.0."""

    rms: float
    peak: float


SILENCE: Final = Level(FLOOR, FLOOR)


class LevelMeter:
    """Loudness of the sound between two readings."""

    __slots__ = ("_count", "_greatest", "_squares")

    def __init__(self) -> None:
        self._count = 0
        self._squares = self._greatest = 0.0

    def add(self, samples: NDArray[np.int16]) -> None:
        """Add samples of any shape."""
        values = samples.astype(np.float64).ravel()
        if len(values):
            self._count += len(values)
            self._squares += float(np.dot(values, values))
            self._greatest = max(self._greatest, float(np.abs(values).max()))

    def read(self) -> Level:
        """Return the level since the last reading; silence if nothing came."""
        mean = self._squares / self._count if self._count else 0.0
        level = Level(_decibels(mean**0.5), _decibels(self._greatest))
        self._count = 0
        self._squares = self._greatest = 0.0
        return level


def _decibels(value: float) -> float:
    if value <= 0:
        return FLOOR
    return max(FLOOR, round(20 * float(np.log10(value / _FULL_SCALE)), 1))
