"""Bit rate of a rendition that several viewers share, from the demands of each. Pure."""

from collections.abc import Hashable
from typing import Final

from openrois_streaming.adaptation.rung import Rung

TOP: Final = 0.9
MIDDLE: Final = 0.6
LOWEST: Final = 0.0
"""Least demand at which a rendition keeps a viewer, as a share of its best viewer's demand.

The highest rung is for the best picture, those below are a compromise, and below the lowest there is no other.
"""

# An encoder that cannot change its rate without a key frame does so in steps, and goes up only after a while.
_COARSE_STEP: Final = 0.8
_COARSE_PATIENCE: Final = 4.0


class Demands:
    """Demands of the viewers of one rendition.

    Its rate is the lowest demand among those close enough to the highest; a viewer that demands less has to leave, or
    is sent more than it can take.
    """

    __slots__ = ("_bitrates", "_tolerance", "rung")

    def __init__(self, rung: Rung, tolerance: float) -> None:
        self.rung = rung
        self._tolerance = tolerance
        self._bitrates: dict[Hashable, float] = {}

    def suit(self, rung: Rung, tolerance: float) -> bool:
        """Set the rung of the rendition; whether that changed it."""
        before = (self.rung, self._tolerance)
        self.rung, self._tolerance = rung, tolerance
        return before != (rung, tolerance)

    def put(self, viewer: Hashable, bitrate: float) -> None:
        """Set the demand of `viewer` to `bitrate` (bit/s)."""
        self._bitrates[viewer] = bitrate

    def drop(self, viewer: Hashable) -> None:
        """Remove the demand of `viewer`."""
        self._bitrates.pop(viewer, None)

    def least(self, viewer: Hashable | None = None) -> float:
        """Return the bit/s below which `viewer`, or a new one, would be sent more than it demands."""
        others = [bitrate for each, bitrate in self._bitrates.items() if each != viewer]
        best = min(max(others, default=0.0), self.rung.max_bitrate)
        return max(self.rung.min_bitrate, self._tolerance * best)

    @property
    def viewers(self) -> int:
        """Number of viewers with a demand."""
        return len(self._bitrates)

    @property
    def bitrate(self) -> int:
        """Rate to encode with, in bit/s; the lowest of the rung without demands."""
        best = max(self._bitrates.values(), default=0.0)
        taken = min((each for each in self._bitrates.values() if each >= self._tolerance * best), default=0.0)
        return round(max(self.rung.min_bitrate, min(taken, self.rung.max_bitrate)))


class CoarseRate:
    """Bit rate in steps of a fifth: it falls at once, and rises when the step has been open for some seconds."""

    __slots__ = ("_open_since", "_rate")

    def __init__(self) -> None:
        self._rate: int | None = None
        self._open_since: float | None = None

    def follow(self, bitrate: int, rung: Rung, now: float) -> int:
        """Return the rate to encode with for `bitrate`: the highest step of the rung that is not above it."""
        step = float(rung.max_bitrate)
        while step > bitrate:
            step *= _COARSE_STEP
        wanted = max(rung.min_bitrate, round(step))
        if self._rate is None or wanted <= self._rate:
            self._rate, self._open_since = wanted, None
        elif self._open_since is None:
            self._open_since = now
        elif now - self._open_since >= _COARSE_PATIENCE:
            self._rate, self._open_since = wanted, None
        return self._rate
