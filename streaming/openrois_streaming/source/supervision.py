"""How long a source has given nothing, judged by frames and not by connections. Pure.

Times are seconds of one monotonic clock and are given by the caller.
"""

from enum import Enum
from typing import Final

LOOK_INTERVAL: Final = 0.2
"""Seconds between two looks at a source."""

QUIET: Final = 1.0
"""Seconds without a frame after which a source counts as stalled, as a stream does."""

HUNG: Final = 5.0
"""Seconds without a frame after which a source counts as hung: it will not come back by itself."""

_LATE: Final = 1.0
"""Seconds a look may be late before the delay counts as this process's own: it was stopped, or the machine slept."""


class Pace(Enum):
    """How a source fares."""

    WELL = "well"
    """It gives frames, or nobody wants any."""
    QUIET = "quiet"
    """It has given none for `QUIET` seconds."""
    HUNG = "hung"
    """It has given none for `HUNG` seconds."""


class SourceWatch:
    """How long a source that should give frames has given none. It is to be looked at every `LOOK_INTERVAL`.

    Time in which this process stood still does not count: the source had nobody to give its frames to.
    """

    __slots__ = ("_looked", "_since")

    def __init__(self, now: float) -> None:
        self._since = self._looked = now

    def look(self, now: float, last_frame_at: float | None, *, wanted: bool = True) -> Pace:
        """Judge it by when it gave its last frame, if it has given any since it was `wanted`."""
        quiet = self.quiet_for(now, last_frame_at, wanted=wanted)
        if quiet < QUIET:
            return Pace.WELL
        return Pace.QUIET if quiet < HUNG else Pace.HUNG

    def quiet_for(self, now: float, last_frame_at: float | None, *, wanted: bool = True) -> float:
        """The seconds for which it has given nothing although it should."""
        if not wanted or now - self._looked >= _LATE:
            self._since = now
        elif last_frame_at is not None:
            self._since = max(self._since, last_frame_at)
        self._looked = now
        return now - self._since
