"""Finding the marker of `synthetic.Tone` in sound that came over a network: a burst of 1 kHz out of silence. Pure."""

import numpy as np
from numpy.typing import NDArray

from openrois_streaming.source.source import SAMPLE_RATE

_WINDOW = SAMPLE_RATE // 1000
"""Samples of a millisecond, which is one period of the marker."""

# The effective value of a marker at full level is 11,300. A codec smears its edge over some ms, half before and half
# after, so that half of the level is where the edge was.
_LOUD = 5_650.0
_QUIET_BEFORE = 300


class ClickFinder:
    """Tells where bursts begin in a stream of samples, to a millisecond."""

    def __init__(self) -> None:
        self._rest: NDArray[np.int16] = np.empty(0, np.int16)
        self._quiet = _QUIET_BEFORE

    def find(self, samples: NDArray[np.int16]) -> list[int]:
        """Where bursts begin in the next `samples` (int16, one channel); below 0 is in those before."""
        offset = -len(self._rest)
        whole = np.concatenate((self._rest, samples))
        windows = len(whole) // _WINDOW
        self._rest = whole[windows * _WINDOW :]
        blocks = whole[: windows * _WINDOW].reshape(windows, _WINDOW).astype(np.float32)
        loud = np.sqrt(np.mean(blocks**2, axis=1)) >= _LOUD
        found = []
        for window in range(windows):
            if not loud[window]:
                self._quiet += 1
                continue
            if self._quiet >= _QUIET_BEFORE:
                found.append(offset + window * _WINDOW)
            self._quiet = 0
        return found
