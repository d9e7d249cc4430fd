"""Tasks that belong to an object, which is notified of their failures and which none of them outlives."""

import asyncio
import logging
from collections.abc import Callable, Coroutine
from typing import Any, TypeAlias, TypeVar

T = TypeVar("T")
Task: TypeAlias = asyncio.Task[T]

CLOSE_TIMEOUT = 5.0
"""Seconds that `aclose` waits for tasks it has cancelled."""

_log = logging.getLogger(__name__)


class OwnedTasks:
    """Running tasks of one owner. `on_failure` is called in the event loop with the exception of a task."""

    def __init__(self, name: str, on_failure: Callable[[BaseException], None]) -> None:
        self._name = name
        self._on_failure = on_failure
        self._running: set[asyncio.Task[Any]] = set()

    def start(self, work: Coroutine[Any, Any, T], name: str) -> asyncio.Task[T]:
        """Start `work` as a task of this owner."""
        task = asyncio.create_task(work, name=f"{self._name} {name}")
        self._running.add(task)
        task.add_done_callback(self._done)
        return task

    async def finished(self) -> None:
        """Wait until all tasks have ended; the tasks themselves have to bound that time."""
        while self._running:
            await asyncio.wait(self._running)

    async def aclose(self) -> None:
        """Cancel all tasks and wait until they have ended. A task that calls this is left running."""
        others = self._running - {asyncio.current_task()}
        for task in others:
            task.cancel()
        if others:
            _, late = await asyncio.wait(others, timeout=CLOSE_TIMEOUT)
            for task in late:
                _log.error("%s does not end", task.get_name())

    def _done(self, task: asyncio.Task[Any]) -> None:
        self._running.discard(task)
        if task.cancelled():
            return
        error = task.exception()
        if error is not None:
            self._on_failure(error)
