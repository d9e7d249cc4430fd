"""The thread of an opened source, and the bounded queue by which its items reach the reader in the event loop."""

import asyncio
import contextlib
import logging
import threading
from collections import deque
from collections.abc import Callable
from types import TracebackType
from typing import Generic, Self, TypeVar

JOIN_TIMEOUT = 2.0
"""Seconds that closing waits for the thread to finish its step."""

_log = logging.getLogger(__name__)


class Worker:
    """Thread that runs `work` for as long as the async context lasts. `work` returns soon after `stop` was called.

    `failed` is called, in the thread, with the exception of `work`, which ends the source.
    """

    def __init__(
        self, name: str, work: Callable[[], None], stop: Callable[[], None], failed: Callable[[Exception], None]
    ) -> None:
        self._stop = stop
        self._failed = failed
        self._work = work
        self._finished = asyncio.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    async def __aenter__(self) -> Self:
        self._loop = asyncio.get_running_loop()
        self._thread.start()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop()
        try:
            async with asyncio.timeout(JOIN_TIMEOUT):
                await self._finished.wait()
        except TimeoutError:
            _log.error("%s: the decoder does not return; its thread is abandoned", self._thread.name)
        else:
            # The thread has nothing left to do but to return.
            self._thread.join(JOIN_TIMEOUT)

    def _run(self) -> None:
        try:
            self._work()
        except Exception as error:
            _log.exception("%s: decoding has ended", self._thread.name)
            self._failed(error)
        finally:
            # A loop that was closed without closing this context has no reader left.
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._finished.set)


T = TypeVar("T")


class Handover(Generic[T]):
    """Iterator that is filled from any thread. At most `depth` items wait; `lost` counts the dropped ones.

    To be made in the event loop of its one reader.
    """

    def __init__(self, depth: int) -> None:
        self.lost = 0
        self._loop = asyncio.get_running_loop()
        self._news = asyncio.Event()
        # Threads use the following attributes, under this lock.
        self._lock = threading.Lock()
        self._items: deque[T] = deque(maxlen=depth)
        self._woken = self._ended = False
        self._cause: Exception | None = None

    def put(self, item: T) -> None:
        """Queue `item`; ignored after the end."""
        with self._lock:
            if self._ended:
                return
            self.lost += len(self._items) == self._items.maxlen
            self._items.append(item)
            self._wake_reader()

    def end_input(self, cause: Exception | None = None) -> None:
        """End the input: the reader gets the waiting items, and then `cause` is raised if there is one."""
        with self._lock:
            if not self._ended:
                self._ended, self._cause = True, cause
                self._wake_reader()

    def _wake_reader(self) -> None:
        if not self._woken:
            self._woken = True
            # A closed loop has no reader left.
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._news.set)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        while True:
            with self._lock:
                if self._items:
                    return self._items.popleft()
                self._woken = False
                self._news.clear()
                if self._ended:
                    if self._cause is not None:
                        raise self._cause
                    raise StopAsyncIteration
            await self._news.wait()
