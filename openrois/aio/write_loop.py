"""Writing in the background: what is put is written soon, and again after a while where that fails."""

import asyncio
from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack
from types import TracebackType
from typing import Final, Self

from openrois.aio.tasks import TaskScope

__all__ = ["WriteLoop"]

_RETRY: Final = 1.0
"""Seconds after a write that failed until the next one."""


class WriteLoop(AbstractAsyncContextManager["WriteLoop"]):
    """Calls a function that writes as long as something waits for it. Leaving the block ends that at once.

    Args:
        is_waiting: whether something waits to be written.
        write: writes a part of it; returns whether that worked.
        sleep: waits for some seconds.
    """

    def __init__(
        self,
        is_waiting: Callable[[], bool],
        write: Callable[[], Awaitable[bool]],
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._is_waiting = is_waiting
        self._write = write
        self._sleep = sleep
        self._more = asyncio.Event()
        self._empty = asyncio.Event()
        self._empty.set()
        self._stack = AsyncExitStack()

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            tasks = await stack.enter_async_context(TaskScope())
            tasks.start(self._keep_writing())
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._stack.aclose()

    def wake(self) -> None:
        """Write soon: something waits now."""
        self._more.set()
        self._empty.clear()

    async def flushed(self, seconds: float) -> bool:
        """Wait until everything is written, or for so long; tell whether it is."""
        try:
            async with asyncio.timeout(seconds):
                await self._empty.wait()
        except TimeoutError:
            return False
        return True

    async def _keep_writing(self) -> None:
        while True:
            await self._more.wait()
            self._more.clear()
            while self._is_waiting():
                if not await self._write():
                    await self._sleep(_RETRY)
            self._empty.set()
