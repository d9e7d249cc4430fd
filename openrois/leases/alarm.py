"""One alarm: at the earliest of the times that it is set to, a function is called."""

import asyncio
from collections.abc import Awaitable, Callable

from openrois.aio.tasks import TaskScope

__all__ = ["Alarm"]


class Alarm:
    """Waits for one time at a time.

    Args:
        ring: does what is due; may set the alarm again.
        tasks: owns the waiting.
        clock: monotonic seconds.
        sleep: waits for some seconds.
    """

    def __init__(
        self,
        ring: Callable[[], None],
        tasks: TaskScope,
        clock: Callable[[], float],
        sleep: Callable[[float], Awaitable[None]],
    ) -> None:
        self._ring = ring
        self._tasks = tasks
        self._clock = clock
        self._sleep = sleep
        self._set: tuple[float, asyncio.Task[None]] | None = None

    def set(self, due: float | None) -> None:
        """Ring at `due`, or before, where it is set to an earlier time already; None changes nothing."""
        if due is None or (self._set is not None and self._set[0] <= due):
            return
        if self._set is not None:
            self._set[1].cancel()
        self._set = due, self._tasks.start(self._wait(due))

    async def _wait(self, due: float) -> None:
        while (left := due - self._clock()) > 0:
            await self._sleep(left)
        self._set = None
        self._ring()
