"""Rate limit: some at once, and so many a second from then on. The clock is an argument. Pure."""

from collections.abc import Callable

__all__ = ["RateLimit"]


class RateLimit:
    """A bucket that holds `at_once` and is filled with `per_second`.

    Args:
        at_once: how many may happen together.
        per_second: how many may happen in the long run.
        clock: monotonic seconds.
    """

    def __init__(self, at_once: int, per_second: float, clock: Callable[[], float]) -> None:
        self._at_once = at_once
        self._per_second = per_second
        self._clock = clock
        self._left = float(at_once)
        self._filled = clock()

    def admits(self) -> bool:
        """Tell whether one more may happen now, and count it if so."""
        self._fill()
        if self._left < 1:
            return False
        self._left -= 1
        return True

    def wait(self) -> float:
        """Return in how many seconds one more may happen."""
        self._fill()
        return max(0.0, 1 - self._left) / self._per_second

    def _fill(self) -> None:
        now = self._clock()
        self._left = min(self._at_once, self._left + (now - self._filled) * self._per_second)
        self._filled = now
