"""Waits between the attempts to make a lost connection again."""

import asyncio
import random
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from openrois.transport.backoff import Backoff

__all__ = ["Reconnect"]


@dataclass(frozen=True, slots=True)
class Reconnect:
    """Waits between attempts: longer each time, and by chance, so that a thousand do not come at once.

    Attributes:
        first: the longest first wait, seconds.
        factor: by how much each wait is longer than the one before.
        limit: the longest wait, seconds.
        random: a number from 0 up to 1; a wait is up to what it could be.
        sleep: waits for some seconds.
        clock: monotonic seconds.
    """

    first: float = 0.5
    factor: float = 1.5
    limit: float = 10.0
    random: Callable[[], float] = random.random
    sleep: Callable[[float], Awaitable[None]] = asyncio.sleep
    clock: Callable[[], float] = time.monotonic

    def backoff(self) -> Backoff:
        """Return the waits of one connection, before chance."""
        return Backoff(self.first, self.factor, self.limit)

    def spread(self, delay: float) -> float:
        """Return `delay` or less, by chance."""
        return delay * self.random()
