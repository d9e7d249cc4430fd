"""Iterators that are read for a source: asynchronous ones in the event loop, blocking ones in threads of their own."""

import asyncio
import logging
import threading
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Iterator
from contextlib import aclosing, asynccontextmanager, suppress
from typing import Any, Final, Generic, NamedTuple, TypeAlias, TypeVar, cast

from openrois_streaming.clock import MediaClock

T = TypeVar("T")

Items: TypeAlias = Callable[[], Iterator[T] | AsyncIterator[T]]
"""Function that returns an iterator whenever the source is opened: a generator function, most often."""

CLOSE_TIMEOUT: Final = 2.0
"""Seconds that a thread has to come back from its last read when the source is closed."""

_log = logging.getLogger(__name__)


class Item(NamedTuple, Generic[T]):
    """What an iterator gave: its number since the source was made, and the moment at which it came."""

    number: int
    value: T
    came_at: float


class IteratedSource(Generic[T]):
    """Reader of an iterator. A blocking iterator is read in a thread, and closed there.

    Args:
        items: returns the iterator; called whenever the source is opened, in the event loop: it must not block.
        clock: the media clock.
        depth: items that may wait while the event loop is busy; the oldest is lost first, and its number is missing.
        name: its name in the log and in errors.
    """

    def __init__(self, items: Items[T], *, clock: MediaClock, depth: int, name: str) -> None:
        self._items = items
        self._clock = clock
        self._depth = depth
        self._name = name
        self._number = 0
        self._reader: _Reader[T] | None = None

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[Item[T]]]:
        """Read the iterator for as long as the context lasts.

        Raises:
            RuntimeError: the thread of an earlier opening has not come back from its last read.
            TypeError: `items` returned no iterator.
        """
        if self._reader is not None and not self._reader.has_ended:
            raise RuntimeError(
                f"{self._name} has not come back from its last read, and is opened when it does:"
                " if it stays away, reconnect the device or restart the adapter"
            )
        made = self._items()
        if isinstance(made, AsyncIterator):
            try:
                async with aclosing(self._numbered(made)) as items:
                    yield items
            finally:
                if isinstance(made, AsyncGenerator):
                    await made.aclose()
        elif isinstance(made, Iterator):
            self._reader = reader = _Reader(made, self._clock, self._number, self._depth, self._name)
            reader.start()
            try:
                async with aclosing(reader.items()) as items:
                    yield items
            finally:
                await reader.stop()
                self._number = reader.number
        else:
            raise TypeError(f"{self._name} must be a function that returns an iterator, not a {type(made).__name__}")

    async def _numbered(self, values: AsyncIterator[T]) -> AsyncGenerator[Item[T], None]:
        async for value in values:
            item = Item(self._number, value, self._clock.now())
            self._number += 1
            yield item
            await asyncio.sleep(0)  # one that never waits must not stop all else


class _Reader(threading.Thread, Generic[T]):
    """Thread that reads a blocking iterator. It is a daemon: a device that hangs must not keep the process."""

    def __init__(self, values: Iterator[T], clock: MediaClock, number: int, depth: int, name: str) -> None:
        super().__init__(name=f"capture {name}", daemon=True)
        self.number = number
        self._values = values
        self._clock = clock
        self._loop = asyncio.get_running_loop()
        self._waiting: deque[Item[T]] = deque(maxlen=depth)
        self._news = asyncio.Event()
        self._announced = False
        """Whether the event loop has been told of what waits, and has not looked yet."""
        self._stopping = threading.Event()
        self._ended = asyncio.Event()
        self._failure: Exception | None = None

    def run(self) -> None:
        """Read until the iterator ends, fails, or the source is closed."""
        try:
            for value in self._values:
                if self._stopping.is_set():
                    break
                self._waiting.append(Item(self.number, value, self._clock.now()))
                self.number += 1
                if not self._announced:
                    self._announced = True
                    self._call(self._news.set)
        except Exception as error:
            self._failure = error
        finally:
            try:
                # Here, in its own thread, a generator releases its device.
                cast("Any", getattr(self._values, "close", lambda: None))()
            except Exception as error:
                _log.warning("%s: the device may not be released: %r", self.name, error)
            self._call(self._end)

    @property
    def has_ended(self) -> bool:
        """Whether the iterator has been closed; a loop that was closed before is not told."""
        return self._ended.is_set() or not self.is_alive()

    async def items(self) -> AsyncGenerator[Item[T], None]:
        """Yield the items, in order."""
        while True:
            self._announced = False
            while self._waiting:
                yield self._waiting.popleft()
                await asyncio.sleep(0)  # a thread that is faster than its readers must not stop all else
            if self._ended.is_set() and not self._waiting:
                if self._failure is not None:
                    raise self._failure
                return
            await self._news.wait()
            self._news.clear()

    async def stop(self) -> None:
        """Let the thread end; one that does not come back in time ends when it does."""
        self._stopping.set()
        with suppress(TimeoutError):
            async with asyncio.timeout(CLOSE_TIMEOUT):
                await self._ended.wait()
                return
        _log.warning("%s does not come back from its last read; it is released when it does", self.name)

    def _end(self) -> None:
        self._ended.set()
        self._news.set()

    def _call(self, function: Callable[[], None]) -> None:
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(function)
