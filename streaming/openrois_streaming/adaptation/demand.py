"""The bit rate of a rendition that several viewers share, from what each of them can take. Pure."""

from collections.abc import Hashable
from typing import Final

from openrois_streaming.adaptation.rung import Rung

TOP: Final = 0.9
MIDDLE: Final = 0.6
LOWEST: Final = 0.0
"""How far below the best of its viewers a rendition goes so as to keep another one, as a share of the best one's rate.

On the highest rung the best picture is the purpose, on those below it a compromise is, and under the lowest there is
nothing to fall to.
"""

# An encoder that cannot change its rate without a key frame does so in steps, and goes up only after a while.
_COARSE_STEP: Final = 0.8
_COARSE_PATIENCE: Final = 4.0


class Demands:
    """What the viewers of one rendition can take.

    Its rate is the lowest demand among those that are close enough to the highest; who demands less has to leave, or is
    sent more than it can take.
    """

    __slots__ = ("_bitrates", "_tolerance", "rung")

    def __init__(self, rung: Rung, tolerance: float) -> None:
        self.rung = rung
        self._tolerance = tolerance
        self._bitrates: dict[Hashable, float] = {}

    def suit(self, rung: Rung, tolerance: float) -> bool:
        """The rendition is now of this rung; whether that is another than it was."""
        before = (self.rung, self._tolerance)
        self.rung, self._tolerance = rung, tolerance
        return before != (rung, tolerance)

    def put(self, viewer: Hashable, bitrate: float) -> None:
        """`viewer` can take `bitrate` (bit/s) now."""
        self._bitrates[viewer] = bitrate

    def drop(self, viewer: Hashable) -> None:
        """`viewer` has left."""
        self._bitrates.pop(viewer, None)

    def least(self, viewer: Hashable | None = None) -> float:
        """Bit/s below which `viewer`, or a new one, would get more than it can take, whatever it demands."""
        others = [bitrate for each, bitrate in self._bitrates.items() if each != viewer]
        best = min(max(others, default=0.0), self.rung.max_bitrate)
        return max(self.rung.min_bitrate, self._tolerance * best)

    @property
    def viewers(self) -> int:
        """How many demand it."""
        return len(self._bitrates)

    @property
    def bitrate(self) -> int:
        """The rate to encode with, in bit/s; the lowest of the rung when nobody demands it."""
        best = max(self._bitrates.values(), default=0.0)
        taken = min((each for each in self._bitrates.values() if each >= self._tolerance * best), default=0.0)
        return round(max(self.rung.min_bitrate, min(taken, self.rung.max_bitrate)))


class CoarseRate:
    """Follows a bit rate in steps of a fifth: down at once, up when the step has been open for some seconds."""

    __slots__ = ("_open_since", "_rate")

    def __init__(self) -> None:
        self._rate: int | None = None
        self._open_since: float | None = None

    def follow(self, bitrate: int, rung: Rung, now: float) -> int:
        """The rate to encode with when `bitrate` is to be followed, a step of the rung's highest below it."""
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
