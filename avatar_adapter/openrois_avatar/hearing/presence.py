"""Whether there is a sound: none or one source, as a single microphone cannot tell sources apart; pure."""

from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.loudness import LevelMeter
from openrois_streaming.source.source import SAMPLE_RATE

from openrois_avatar.hearing.noise_floor import Loudness

__all__ = ["Presence"]

_INTERVAL: Final = 0.02
"""Seconds of each level: a click of 5 ms counts, a single odd sample does not."""


class Presence:
    """Takes sound in blocks of any length, at 48 kHz."""

    def __init__(self) -> None:
        self._meter = LevelMeter()
        self._filled = 0
        self._loudness = Loudness(_INTERVAL)

    @property
    def number(self) -> int:
        """How many sources there are: 0 or 1."""
        return int(self._loudness.loud)

    def add(self, samples: NDArray[np.int16]) -> int:
        """Take a block of shape (n, channels); returns `number`."""
        wanted = round(_INTERVAL * SAMPLE_RATE)
        while len(samples):
            part, samples = np.split(samples, [wanted - self._filled])
            self._meter.add(part)
            self._filled += len(part)
            if self._filled == wanted:
                self._loudness.add(self._meter.read().rms)
                self._filled = 0
        return self.number
