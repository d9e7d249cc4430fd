"""Fakes for media: a clock that is turned by hand, and a source that is fed by hand."""

import asyncio
import heapq
import itertools
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Generic, TypeVar

T = TypeVar("T")

# As many turns of the loop as the longest chain of tasks and callbacks from a timer to the reader of an item takes.
_TURNS = 20


async def settle() -> None:
    """Let every task run that can run without the clock or another thread."""
    for _ in range(_TURNS):
        await asyncio.sleep(0)


class VirtualClock:
    """A `MediaClock` that stands still until `advance` is awaited. The wall clock runs along, and can be stepped."""

    def __init__(self, now: float = 1000.0, wall: float = 1_800_000_000.0) -> None:
        self._now = now
        self._wall = wall
        self._order = itertools.count()
        self._sleepers: list[tuple[float, int, asyncio.Future[None]]] = []

    def now(self) -> float:
        return self._now

    def wall(self) -> float:
        return self._wall

    @property
    def sleepers(self) -> int:
        """How many are waiting for a moment to come."""
        return sum(1 for _, _, sleeper in self._sleepers if not sleeper.done())

    def step_wall(self, seconds: float) -> None:
        """Step the wall clock, as a time server or an administrator does."""
        self._wall += seconds

    async def sleep_until(self, deadline: float) -> None:
        if deadline <= self._now:
            return
        sleeper = asyncio.get_running_loop().create_future()
        heapq.heappush(self._sleepers, (deadline, next(self._order), sleeper))
        await sleeper

    def jump(self, seconds: float) -> None:
        """Let time pass without giving anybody a turn before all of it has passed, as when the loop was blocked."""
        self._move(self._now + seconds)
        while self._sleepers and self._sleepers[0][0] <= self._now:
            self._wake_first()

    async def advance(self, seconds: float) -> None:
        """Let time pass: each sleeper wakes exactly at its deadline and acts before time goes on."""
        await settle()
        end = self._now + seconds
        while self._sleepers and self._sleepers[0][0] <= end:
            self._move(max(self._now, self._sleepers[0][0]))
            self._wake_first()
            await settle()
        self._move(end)

    def _move(self, now: float) -> None:
        self._wall += now - self._now
        self._now = now

    def _wake_first(self) -> None:
        _, _, sleeper = heapq.heappop(self._sleepers)
        if not sleeper.done():
            sleeper.set_result(None)


class FedSource(Generic[T]):
    """A `MediaSource` whose items, end and failure are given by the test. It records how it is opened and closed."""

    def __init__(self) -> None:
        self.opened = 0
        self.closed = 0
        self.pulled = 0
        self._queue: asyncio.Queue[tuple[T] | Exception | None] = asyncio.Queue()

    @property
    def is_open(self) -> bool:
        return self.opened > self.closed

    async def feed(self, *items: T) -> None:
        """Yield `items`, one after the other, and let the readers take them."""
        for item in items:
            self._queue.put_nowait((item,))
            await settle()

    def feed_at_once(self, *items: T) -> None:
        """Yield `items` without giving the readers a turn in between."""
        for item in items:
            self._queue.put_nowait((item,))

    async def end(self, cause: Exception | None = None) -> None:
        """End the source, or let it fail with `cause`."""
        self._queue.put_nowait(cause)
        await settle()

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[T]]:
        self.opened += 1
        try:
            yield self._items()
        finally:
            self.closed += 1

    async def _items(self) -> AsyncIterator[T]:
        while (entry := await self._queue.get()) is not None:
            if isinstance(entry, Exception):
                raise entry
            self.pulled += 1
            yield entry[0]
