"""A mouth that follows the loudness of the operator's voice."""

from collections.abc import Sequence
from math import exp, log10
from typing import Final

import numpy as np
from numpy.typing import NDArray

QUIET: Final = -45.0
LOUD: Final = -15.0
"""Root mean squares in dBFS at which the mouth begins to open, and at which it is open."""
_OPENING: Final = 0.03
_CLOSING: Final = 0.09
"""Time constants in seconds."""
HOLD: Final = 0.12
"""Seconds without a new loudness after which the mouth closes."""


def loudness(blocks: Sequence[NDArray[np.int16]]) -> float:
    """Return the loudness of blocks of sound of any shape together, 0 (quiet) to 1 (loud)."""
    values = np.concatenate([block.ravel() for block in blocks]).astype(np.float64) if blocks else np.zeros(0)
    power = float(np.mean(np.square(values))) if len(values) else 0.0
    if power <= 0.0:
        return 0.0
    level = 10 * log10(power / 32_768.0**2)
    return min(1.0, max(0.0, (level - QUIET) / (LOUD - QUIET)))


class VoiceMouth:
    """The opening of the mouth. Times are seconds on one clock and never go back."""

    def __init__(self) -> None:
        self._time = 0.0
        self._value = 0.0
        self._goal = 0.0

    def set_loudness(self, time: float, loudness: float) -> None:
        """Set the loudness from now on, 0 to 1."""
        self._value = self.opening(time)
        self._time, self._goal = time, loudness

    def opening(self, time: float) -> float:
        """Return the opening of the mouth at a time, 0 to 1."""
        since = time - self._time
        reached = self._towards(self._value, self._goal, min(since, HOLD))
        return reached if since <= HOLD else self._towards(reached, 0.0, since - HOLD)

    @staticmethod
    def _towards(value: float, goal: float, seconds: float) -> float:
        return goal + (value - goal) * exp(-seconds / (_OPENING if goal > value else _CLOSING))
