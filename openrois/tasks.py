"""A parent for tasks that outlive the call that started them."""

import asyncio
import logging
from collections.abc import Coroutine
from types import TracebackType
from typing import Any, Self

__all__ = ["TaskScope"]

_log = logging.getLogger(__name__)


class TaskScope:
    """Owns tasks: leaving the block cancels and awaits them. One task's failure is logged and ends only that task.

    A `TaskGroup` would end every other task too, and here each belongs to a different application.
    """

    def __init__(self) -> None:
        self._tasks: set[asyncio.Task[None]] = set()
        self._left = False

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        # A task may start another one while it ends.
        while tasks := tuple(self._tasks):
            for task in tasks:
                task.cancel()
            await asyncio.wait(tasks)
        self._left = True

    def __len__(self) -> int:
        return len(self._tasks)

    def start(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Run `work` until it ends or the scope does.

        Raises:
            RuntimeError: the scope has ended.
        """
        if self._left:
            work.close()
            raise RuntimeError("nothing can be started in a scope that has ended")
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)
        return task

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            _log.error("a task failed", exc_info=error)
