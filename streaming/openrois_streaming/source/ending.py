"""The wait for a task that was cancelled: whatever is cancelled meanwhile, what it uses is closed after its end."""

import asyncio
from typing import Any

__all__ = ["wait_until_ended"]


async def wait_until_ended(task: asyncio.Task[Any], timeout: float | None = None) -> None:
    """Wait until a task has ended that was cancelled, for `timeout` seconds at most.

    A cancellation of the wait is raised after that: what the task uses is not to be closed before it has ended.
    """
    loop = asyncio.get_running_loop()
    until = None if timeout is None else loop.time() + timeout
    cancellation: asyncio.CancelledError | None = None
    while True:
        try:
            await asyncio.wait({task}, timeout=None if until is None else max(0.0, until - loop.time()))
            break
        except asyncio.CancelledError as error:
            cancellation = error
    if cancellation is not None:
        raise cancellation
