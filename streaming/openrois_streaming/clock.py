"""The media clock: capture times, pacing and budgets are read from it, and tests set it by hand."""

import asyncio
import time
from typing import Protocol

# Below this an event loop's timer is a busy turn (uvloop counts whole milliseconds).
_SHORTEST_SLEEP = 0.001


class MediaClock(Protocol):
    """Source of capture times, and of the time of day that belongs to them."""

    def now(self) -> float:
        """Monotonic seconds. Callable from any thread."""
        ...

    def wall(self) -> float:
        """Seconds since the epoch (UTC); it may be stepped. Callable from any thread."""
        ...

    async def sleep_until(self, deadline: float) -> None:
        """Wait until `now()` has reached `deadline`; return at once if it has passed."""
        ...


class SystemClock:
    """Clock of this machine. `now()` is CLOCK_MONOTONIC, which all processes of one machine share."""

    def now(self) -> float:
        """Seconds of CLOCK_MONOTONIC."""
        return time.monotonic()

    def wall(self) -> float:
        """Seconds since the epoch."""
        return time.time()

    async def sleep_until(self, deadline: float) -> None:
        """Sleep until `now()` has reached `deadline`; up to about 1 ms later, the granularity of the loop's timers."""
        while (remaining := deadline - self.now()) > 0:  # noqa: ASYNC110 - time is what is waited for
            await asyncio.sleep(max(remaining, _SHORTEST_SLEEP))


def wall_at(clock: MediaClock, moment: float) -> float:
    """The time of day (epoch seconds) at `moment`, a time of `clock.now()`."""
    return clock.wall() - (clock.now() - moment)
