"""The noise floor: how loud the background is, and whether there is a sound above it. Pure."""

from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.loudness import LevelMeter
from openrois_streaming.source.source import SAMPLE_RATE

__all__ = ["Loudness", "NoiseFloor", "Presence"]

LOWEST: Final = -65.0
"""dB of full scale; a floor that is lower counts as this, so that rustling in a silent room is nothing."""
HIGHEST: Final = -35.0
"""dB of full scale; a floor that is higher counts as this, so that what is really loud never becomes background."""
_INTERVAL: Final = 0.02
"""Seconds of each level: a click of 5 ms counts, a single odd sample does not."""
MEMORY: Final = 10.0
"""Seconds for which a quiet moment is remembered: a sound that goes on unchanged for longer becomes background."""


class NoiseFloor:
    """The level of the quietest moment of the last `MEMORY` seconds.

    Args:
        interval: seconds from one level to the next.
    """

    def __init__(self, interval: float) -> None:
        self._length = round(MEMORY / interval)
        self._count = 0
        self._lowest: deque[tuple[int, float]] = deque()
        """Levels that are lower than all that came later, with their numbers: the first is the lowest of all."""

    def add(self, level: float) -> float:
        """Add a level in dB of full scale, and return the floor, between `LOWEST` and `HIGHEST`."""
        while self._lowest and self._lowest[-1][1] >= level:
            self._lowest.pop()
        self._lowest.append((self._count, level))
        if self._lowest[0][0] <= self._count - self._length:
            self._lowest.popleft()
        self._count += 1
        return min(HIGHEST, max(LOWEST, self._lowest[0][1]))


class Loudness:
    """Detects levels above the noise floor, with hysteresis.

    Args:
        interval: seconds from one level to the next.
        on: dB above the floor at which something begins.
        off: dB above the floor below which it may have ended.
        hold: seconds below `off` after which it has.
    """

    def __init__(self, interval: float, *, on: float = 10.0, off: float = 6.0, hold: float = 0.3) -> None:
        self.loud = False
        """Whether there is a sound above the floor."""
        self._floor = NoiseFloor(interval)
        self._on, self._off = on, off
        self._hold = round(hold / interval)
        self._quiet = 0

    def add(self, level: float) -> bool:
        """Add a level in dB of full scale, and return whether it is above the floor in this very moment."""
        above = level - self._floor.add(level)
        self._quiet = 0 if above > self._off else self._quiet + 1
        if self.loud:
            self.loud = self._quiet < self._hold
        else:
            self.loud = above > self._on
        return above > (self._off if self.loud else self._on)


class Presence:
    """Detects sound in blocks of any length, at 48 kHz: none or one source, as one microphone cannot tell more."""

    def __init__(self) -> None:
        self._meter = LevelMeter()
        self._filled = 0
        self._loudness = Loudness(_INTERVAL)

    @property
    def number(self) -> int:
        """The number of sources: 0 or 1."""
        return int(self._loudness.loud)

    def add(self, samples: NDArray[np.int16]) -> int:
        """Add a block of shape (n, channels), and return `number`."""
        wanted = round(_INTERVAL * SAMPLE_RATE)
        while len(samples):
            part, samples = np.split(samples, [wanted - self._filled])
            self._meter.add(part)
            self._filled += len(part)
            if self._filled == wanted:
                self._loudness.add(self._meter.read().rms)
                self._filled = 0
        return self.number
