"""Fakes for media: a clock that is turned by hand, a source that is fed by hand, an encoder controlled by the test."""

import asyncio
import heapq
import itertools
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Generic, TypeVar

import numpy as np
from openrois_streaming.publish.encoder import Chunk
from openrois_streaming.source.source import RawVideo

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
        """Let time pass without a turn of the event loop before its end, as when the loop was blocked."""
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
        self.refusal: BaseException | None = None
        """What opening it raises, if set."""
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
        if self.refusal is not None:
            raise self.refusal
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


def picture(sequence: int, captured_at: float | None = None, *, width: int = 160, height: int = 90) -> RawVideo:
    """A grey picture; by default number n is captured n / 30 s after the virtual clock's start."""
    moment = 1000.0 + sequence / 30 if captured_at is None else captured_at
    return RawVideo(np.full((height * 3 // 2, width), 128, np.uint8), "i420", width, height, sequence, moment)


class FakeEncoder:
    """An `Encoder` whose output says what went in. A test can hold it, and can make it fail.

    The first frame and the forced ones are key frames. `data` is the sequence number as text.
    """

    def __init__(self, bitrate: int) -> None:
        self.bitrate = bitrate
        self.bitrates: list[int] = []
        self.go_on = threading.Event()
        self.go_on.set()
        self.entered = threading.Semaphore(0)
        self.failure: Exception | None = None
        self.encoded: list[int] = []
        self.forced: list[int] = []
        self.thread = threading.current_thread()

    def set_bitrate(self, bitrate: int) -> None:
        self.bitrates.append(bitrate)

    def encode(self, raw: RawVideo, *, key_frame: bool) -> list[Chunk]:
        assert threading.current_thread() is self.thread
        self.entered.release()
        assert self.go_on.wait(timeout=10)
        if self.failure is not None:
            raise self.failure
        self.encoded.append(raw.sequence)
        if key_frame:
            self.forced.append(raw.sequence)
        pts = round(raw.captured_at * 90_000)
        data = str(raw.sequence).encode()
        return [Chunk(data, pts, key_frame or len(self.encoded) == 1, raw.captured_at, (data,))]


class FakeEncoders:
    """Makes fake encoders, as an `Encoding` wants them, and keeps them for the test to look at."""

    def __init__(self) -> None:
        self.made: list[FakeEncoder] = []
        self.failure: Exception | None = None

    def __call__(self, bitrate: int) -> FakeEncoder:
        if self.failure is not None:
            raise self.failure
        self.made.append(FakeEncoder(bitrate))
        return self.made[-1]
