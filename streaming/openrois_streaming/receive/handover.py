"""From a thread to a reader in the event loop: bounded, the oldest is lost, and a loop that is busy is not flooded."""

import asyncio
import contextlib
import threading
from collections import deque
from typing import Generic, Self, TypeVar

T = TypeVar("T")


class Handover(Generic[T]):
    """An iterator that is filled from any thread. At most `depth` items wait; `lost` counts the others.

    To be made in the event loop that reads it; for one reader.
    """

    def __init__(self, depth: int) -> None:
        self.lost = 0
        self._loop = asyncio.get_running_loop()
        self._news = asyncio.Event()
        # Threads touch what follows, under this lock.
        self._lock = threading.Lock()
        self._items: deque[T] = deque(maxlen=depth)
        self._told = self._ended = False
        self._cause: Exception | None = None

    def put(self, item: T) -> None:
        """Hand `item` over; nothing happens after the end."""
        with self._lock:
            if self._ended:
                return
            self.lost += len(self._items) == self._items.maxlen
            self._items.append(item)
            self._tell()

    def end(self, cause: Exception | None = None) -> None:
        """Nothing more will come; the reader gets what waits, and then `cause` is raised if there is one."""
        with self._lock:
            if not self._ended:
                self._ended, self._cause = True, cause
                self._tell()

    def _tell(self) -> None:
        if not self._told:
            self._told = True
            # A loop that was closed has nobody left who wants to know.
            with contextlib.suppress(RuntimeError):
                self._loop.call_soon_threadsafe(self._news.set)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        while True:
            with self._lock:
                if self._items:
                    return self._items.popleft()
                self._told = False
                self._news.clear()
                if self._ended:
                    if self._cause is not None:
                        raise self._cause
                    raise StopAsyncIteration
            await self._news.wait()
