"""Moments of capture, as a source gives them, and as they follow from its samples. Pure."""

from math import inf
from typing import Final, TypeVar

T = TypeVar("T")

OLDEST: Final = 60.0
"""Seconds that what was captured may be old; more is taken for the time of another clock."""
_AHEAD: Final = 1.0
_WINDOW: Final = 2.0
"""Seconds within which the block that waited least gives the moments of all: longer than any block."""


def capture_time(value: T | tuple[T, float], came_at: float, name: str) -> tuple[T, float]:
    """Return a frame and the moment of its capture: the one that is given with it, or that at which it came.

    Args:
        value: a frame, alone or with the moment.
        came_at: the moment at which it came, in seconds of the media clock.
        name: of its source, for the error.

    Raises:
        TypeError: there is something else beside the frame.
        ValueError: the moment is none of the media clock.
    """
    if not isinstance(value, tuple):
        return value, came_at
    if len(value) != 2 or isinstance(value[1], bool) or not isinstance(value[1], float | int):
        raise TypeError(f"{name} must yield a frame, or a frame and its time of capture in seconds")
    frame, captured_at = value
    if not came_at - OLDEST <= captured_at <= came_at + _AHEAD:
        raise ValueError(
            f"{name} gave {captured_at:.3f} as a time of capture: it must be in seconds of time.monotonic(),"
            f" which were {came_at:.3f} then"
        )
    return frame, float(captured_at)


class SampleClock:
    """Moments of blocks of sound that come with none, and often several at once: a buffer of a device or a pipe.

    No block comes before its last sample was there. So the one that waited least tells best when the sound began, and
    the count of the samples gives the moments of the others. Sound that was lost shows as a delay that does not pass:
    the moments follow it within two windows of 2 s.

    Args:
        rate: samples per second.
    """

    def __init__(self, rate: int) -> None:
        self._rate = rate
        self._position = 0
        self._since = -inf
        """Begin of the present window."""
        self._earliest = self._earlier = inf
        """Earliest begin of the sound by the blocks of the present window, and of the one before it."""

    def began(self, count: int, came_at: float) -> float:
        """Return the moment of the first sample of the next block, of `count` samples, which came at `came_at`."""
        start, self._position = self._position, self._position + count
        age = came_at - self._since
        if age > _WINDOW:
            self._earlier = self._earliest if age <= 2 * _WINDOW else inf
            self._earliest, self._since = inf, came_at
        self._earliest = min(self._earliest, came_at - self._position / self._rate)
        return min(self._earlier, self._earliest) + start / self._rate
