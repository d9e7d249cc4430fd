"""What a viewer has heard: how much sound, and how late its markers were. Pure."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from openrois_streaming.source.source import SAMPLE_RATE
from openrois_streaming.testing.clicks import ClickFinder
from openrois_streaming.testing.delays import Delays
from openrois_streaming.testing.pictures import KEPT


@dataclass(frozen=True, slots=True, kw_only=True)
class SoundFigures:
    """What was heard since the count began.

    Attributes:
        seconds: since then.
        heard: seconds of sound that were played, with what was made up for lost packets.
        clicks: markers that were heard.
        delay: from a marker's whole second to when it was heard; None if no marker was.
    """

    seconds: float
    heard: float
    clicks: int
    delay: Delays | None


@dataclass(frozen=True, slots=True)
class HeardClick:
    """A marker: its whole `second` (epoch), and `delay` seconds later it was heard.

    `told` is how much later than that second it was captured by the sender's reports, the least time of a packet's way
    included.
    """

    second: float
    delay: float
    told: float


class SoundLog:
    """Counts sound. Of the delays it keeps the newest ones.

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
        """What was counted up to `now`."""
        return SoundFigures(
            seconds=now - self._since,
            heard=self._heard,
            clicks=self._clicks,
            delay=Delays.of(self._delays),
        )
