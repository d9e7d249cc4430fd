"""The `start`s of one component: one runs at a time, and a `stop` ends those that came before it."""

import asyncio
import math
from collections.abc import Callable, Coroutine
from typing import Any, Generic, TypeVar

from openrois.errors import Aborted

__all__ = ["StartSlot"]

T = TypeVar("T")


class StartSlot(Generic[T]):
    """Runs each start once the one before it, which it cancels, has ended.

    Attributes:
        came: how many came so far.
    """

    def __init__(self) -> None:
        self.came = 0
        self._stopped = 0
        self._running: asyncio.Task[T] | None = None
        self._number = 0

    async def run(self, name: str, work: Callable[[], Coroutine[Any, Any, T]]) -> T:
        """Run a start of the component `name` to its end.

        Raises:
            Aborted: a stop or the next start ended it.
        """
        self.came = number = self.came + 1
        await self.end_running(number)
        if number <= max(self._stopped, self._number):
            raise Aborted(f"{name} was stopped")
        task = asyncio.ensure_future(work())
        self._running, self._number = task, number
        try:
            await asyncio.wait({task})
        except asyncio.CancelledError:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
            raise
        finally:
            if self._running is task:
                self._running = None
        if task.cancelled():
            raise Aborted(f"{name} was stopped")
        return task.result()

    async def stop(self, came: int) -> None:
        """End the first `came` starts, also those that have not begun."""
        self._stopped = max(self._stopped, came)
        await self.end_running(came)

    async def end_running(self, came: float = math.inf) -> None:
        """End the running start, if it is among the first `came`."""
        # While this waits for one to end, another may have begun.
        while (task := self._running) is not None and self._number <= came:
            task.cancel()
            await asyncio.wait({task})
            if self._running is task:
                self._running = None
