"""Supervision of a source by the frames it gives, not by its connection. Pure.

Times are seconds of one monotonic clock and are given by the caller.
"""

from enum import Enum
from typing import Final

CHECK_INTERVAL: Final = 0.2
"""Seconds between two checks of a source."""

QUIET: Final = 1.0
"""Seconds without a frame after which a source counts as stalled, as a stream does."""

HUNG: Final = 5.0
"""Seconds without a frame after which a source counts as hung: it will not recover by itself."""

_LATE: Final = 1.0
"""Seconds that a check may be late before the delay counts as this process's own: it was stopped, or the machine
slept."""


class Pace(Enum):
    """Pace of a source."""

    WELL = "well"
    """The source gives frames, or none are wanted."""
    QUIET = "quiet"
    """No frame for `QUIET` seconds."""
    HUNG = "hung"
    """No frame for `HUNG` seconds."""


class SourceWatch:
    """Watch on a source that should give frames. It is to be judged every `CHECK_INTERVAL`.

    Time in which this process stood still does not count: the source had no reader then.
    """

    __slots__ = ("_judged_at", "_since")

    def __init__(self, now: float) -> None:
        self._since = self._judged_at = now

    def judge(self, now: float, last_frame_at: float | None, *, wanted: bool = True) -> Pace:
        """Judge the source by the time of its last frame, if it has given any since it was `wanted`."""
        quiet = self.quiet_for(now, last_frame_at, wanted=wanted)
        if quiet < QUIET:
            return Pace.WELL
        return Pace.QUIET if quiet < HUNG else Pace.HUNG

    def quiet_for(self, now: float, last_frame_at: float | None, *, wanted: bool = True) -> float:
        """Return the seconds for which the source has given no frame although it should."""
        if not wanted or now - self._judged_at >= _LATE:
            self._since = now
        elif last_frame_at is not None:
            self._since = max(self._since, last_frame_at)
        self._judged_at = now
        return now - self._since
