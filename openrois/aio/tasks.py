"""A parent for tasks that outlive the call that started them."""

import asyncio
import logging
from collections.abc import Coroutine
from types import TracebackType
from typing import Any, Self

__all__ = ["Deadline", "TaskScope"]

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
            raise RuntimeError("this task scope has ended: start tasks within its `async with` block")
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)
        return task

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            _log.error("a task failed", exc_info=error)


class Deadline:
    """A `with` block of the task that runs, which is cancelled after some seconds and then raises `TimeoutError`.

    It does what `asyncio.timeout` does in a third of the time, where that is as long as all the rest of the work.
    """

    __slots__ = ("_cancelling", "_expired", "_expiry", "_seconds", "_task")

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._expired = False

    def __enter__(self) -> None:
        task = asyncio.current_task()
        assert task is not None
        self._task = task
        self._cancelling = task.cancelling()
        self._expiry = task.get_loop().call_later(self._seconds, self._expire)

    def _expire(self) -> None:
        self._expired = True
        self._task.cancel()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._expiry.cancel()
        # A task that was also cancelled from outside ends as cancelled, not with a timeout.
        if self._expired and self._task.uncancel() <= self._cancelling and kind is asyncio.CancelledError:
            raise TimeoutError from error
