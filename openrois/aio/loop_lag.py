"""Measures how late the event loop is: what blocks it delays every connection, STOP too."""

import asyncio
import time
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Final

__all__ = ["LoopLag"]

PERIOD: Final = 0.25
"""Seconds between two measurements."""

STOOD_STILL: Final = 0.5
"""Seconds of lateness beyond which the process itself was suspended: no callback is blamed for that time."""

_LOOKS: Final = round(60 / PERIOD)
"""Measurements that are kept: those of a minute, so that a scrape each minute misses none."""


class LoopLag:
    """Sleeps in a loop, and measures how much too late it wakes.

    Args:
        clock: monotonic seconds.
        sleep: waits for some seconds.

    Attributes:
        last: seconds by which it was late the last time.
        total: seconds by which it was ever late.
        turns: how often it woke: while the loop turns, this grows.
    """

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._clock = clock
        self._sleep = sleep
        self._latest: deque[float] = deque(maxlen=_LOOKS)
        self.last = 0.0
        self.total = 0.0
        self.turns = 0

    async def watch(self) -> None:
        """Measure for ever."""
        while True:
            due = self._clock() + PERIOD
            await self._sleep(PERIOD)
            self.last = max(0.0, self._clock() - due)
            self._latest.append(self.last)
            self.total += self.last
            self.turns += 1

    @property
    def most(self) -> float:
        """The greatest lateness of the last minute in seconds; reading it changes nothing."""
        return max(self._latest, default=0.0)
