"""Sends more than there is to send, for a short while: what a path carries is only seen where it is asked for."""

from collections.abc import Callable
from typing import Protocol, TypeAlias

STEP = 0.01
"""Seconds between two looks at how much is missing."""

MOST_SECONDS = 1.0
"""A longer probe would be a load."""


class Timer(Protocol):
    """A call that is to come."""

    def cancel(self) -> None:
        """Do not call."""
        ...


Later: TypeAlias = Callable[[float, Callable[[], None]], Timer]
"""Calls back after so many seconds, as the event loop's `call_later` does."""


class Probe:
    """Brings what leaves for a viewer up to a bit rate. It ends after `seconds`, or when there is nothing to pad with.

    Args:
        bitrate: of media and padding together, in bit/s.
        pad: sends about so many bytes, and returns how many.
        left: bytes that have left so far.
    """

    def __init__(
        self,
        bitrate: int,
        seconds: float,
        *,
        pad: Callable[[int], int],
        left: Callable[[], int],
        now: Callable[[], float],
        later: Later,
    ) -> None:
        self._bitrate = bitrate
        self._pad = pad
        self._left = left
        self._now = now
        self._later = later
        self._began = now()
        self._until = self._began + min(seconds, MOST_SECONDS)
        self._before = left()
        self._timer = later(STEP, self._look)

    def stop(self) -> None:
        """Send no more."""
        self._timer.cancel()

    def _look(self) -> None:
        now = self._now()
        missing = round(self._bitrate / 8 * (now - self._began)) - (self._left() - self._before)
        if missing > 0 and self._pad(missing) == 0:
            return
        if now < self._until:
            self._timer = self._later(STEP, self._look)
