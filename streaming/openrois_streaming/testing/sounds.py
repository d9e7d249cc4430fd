"""Figures of the sound that a viewer has received: its length, and the delay of its markers. Pure."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from openrois_streaming.source.source import SAMPLE_RATE
from openrois_streaming.testing.delays import Delays
from openrois_streaming.testing.pictures import KEPT


@dataclass(frozen=True, slots=True, kw_only=True)
class SoundFigures:
    """Figures of sound since the count began.

    Attributes:
        seconds: since then.
        heard: seconds of sound that were played, concealed losses included.
        clicks: markers that were played.
        delay: from a marker's whole second until it was played; None without markers.
    """

    seconds: float
    heard: float
    clicks: int
    delay: Delays | None


@dataclass(frozen=True, slots=True)
class HeardClick:
    """Marker at a whole `second` (epoch) that was played `delay` seconds later.

    `told` is how much later than that second it was captured by the sender's reports, the least travel time of a packet
    included.
    """

    second: float
    delay: float
    told: float


class SoundLog:
    """Log of received sound. It keeps the newest delays.

    Args:
        now: when the count begins, in seconds of the media clock.
    """

    def __init__(self, now: float) -> None:
        self._finder = ClickFinder()
        self.blocks = 0
        """Blocks since the very beginning."""
        self.clicks = 0
        """Markers since the very beginning."""
        self.restart(now)

    def restart(self, now: float) -> None:
        """Begin to count anew."""
        self._since = now
        self._heard = 0.0
        self._clicks = 0
        self._delays: deque[float] = deque(maxlen=KEPT)

    def add(self, samples: NDArray[np.int16], captured: float, wall: float) -> list[HeardClick]:
        """Count a block of sound, and return the markers in it.

        Args:
            samples: int16 of shape (n,), one channel at 48 kHz.
            captured: when its first sample was captured by the sender's reports, epoch seconds.
            wall: when it was played, epoch seconds.
        """
        self._heard += len(samples) / SAMPLE_RATE
        self.blocks += 1
        clicks = []
        for start in self._finder.find(samples):
            heard = wall + start / SAMPLE_RATE
            second = math.floor(heard)
            clicks.append(HeardClick(second, heard - second, captured + start / SAMPLE_RATE - second))
        self._clicks += len(clicks)
        self.clicks += len(clicks)
        self._delays.extend(click.delay for click in clicks)
        return clicks

    def figures(self, now: float) -> SoundFigures:
        """Return the counts up to `now`."""
        return SoundFigures(
            seconds=now - self._since,
            heard=self._heard,
            clicks=self._clicks,
            delay=Delays.of(self._delays),
        )


_WINDOW = SAMPLE_RATE // 1000
"""Samples of a millisecond, which is one period of the marker."""

# The effective value of a marker at full level is 11,300. A codec smears its edge over some ms, half before and half
# after, so that half of the level is where the edge was.
_LOUD = 5_650.0
_QUIET_BEFORE = 300


class ClickFinder:
    """Finder of bursts of 1 kHz out of silence in a stream of samples, to a millisecond."""

    def __init__(self) -> None:
        self._rest: NDArray[np.int16] = np.empty(0, np.int16)
        self._quiet = _QUIET_BEFORE

    def find(self, samples: NDArray[np.int16]) -> list[int]:
        """Return where bursts begin in the next `samples` (int16, one channel); below 0 is in earlier ones."""
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
