"""Moments of capture, as a source gives them. Pure."""

from typing import Final, TypeVar

T = TypeVar("T")

OLDEST: Final = 60.0
"""Seconds that what was captured may be old; more is taken for the time of another clock."""
_AHEAD: Final = 1.0


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
