"""Bounded queues that a reader iterates over; what it is too slow for is dropped, oldest first, and counted."""

import asyncio
from collections import deque
from collections.abc import Callable
from types import TracebackType
from typing import Any, Final, Generic, Self, TypeVar

__all__ = ["BUFFER", "Feed"]

BUFFER: Final = 256
"""Items that may wait in a feed for its reader."""

T = TypeVar("T")


def _everything(_item: Any) -> bool:
    return True


class Feed(Generic[T]):
    """Items that arrive from now on, as an asynchronous iterator: `async for item in feed`.

    It ends with the client, or with `close`, which `async with` calls. It need not be closed: a feed without a reader
    is garbage-collected.
    """

    def __init__(self, buffer: int = BUFFER, wants: Callable[[Any], bool] = _everything) -> None:
        if buffer < 1:
            raise ValueError("buffer must be at least 1")
        self._items: deque[T] = deque()
        self._buffer = buffer
        self._wants = wants
        self._news = asyncio.Event()
        self._ended = False
        self._error: BaseException | None = None
        self._dropped = 0

    @property
    def dropped(self) -> int:
        """Number of items that were dropped because the reader was too slow."""
        return self._dropped

    def offer(self, item: Any) -> None:
        """Add an item if it is wanted; the oldest that waits makes room for it."""
        if self._ended or not self._wants(item):
            return
        if len(self._items) >= self._buffer:
            self._items.popleft()
            self._dropped += 1
        self._items.append(item)
        self._news.set()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Accept no more items; those that came before can still be read."""
        self.end_feed()

    def end_feed(self, error: BaseException | None = None) -> None:
        """End the feed once the reader has the items that wait, with `error` if there is one."""
        if not self._ended:
            self._ended, self._error = True, error
        self._news.set()

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> T:
        while not self._items:
            if self._error is not None:
                raise self._error
            if self._ended:
                raise StopAsyncIteration
            self._news.clear()
            await self._news.wait()
        return self._items.popleft()
