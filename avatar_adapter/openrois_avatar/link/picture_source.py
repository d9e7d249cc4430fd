"""The pictures of an engine as a source of the media plane, which outlives the engine and its connection."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Final, NamedTuple

from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import RawVideo

from openrois_avatar.link.picture_demand import PictureDemand
from openrois_avatar.link.picture_memory import PictureMemory
from openrois_avatar.link.protocol import Video
from openrois_avatar.link.raw_video import raw_video

MAX_AGE: Final = 1.0
"""Seconds. An older timestamp is of another clock than ours; so is one from the future."""
MAX_AHEAD: Final = 0.5
"""Seconds by which sound may be sent ahead of its time."""
_TICK: Final = 0.001


def believed(timestamp_ns: int, now: float, ahead: float) -> float:
    """Return an engine's timestamp in seconds of the media clock, which is CLOCK_MONOTONIC too.

    An impossible timestamp (older than `MAX_AGE`, or more than `ahead` seconds later than now) becomes `now`, the time
    of arrival.
    """
    claimed = timestamp_ns / 1e9
    return claimed if now - MAX_AGE <= claimed <= now + ahead else now


class Timestamps:
    """Converts the timestamps of an engine's pictures into times of the media clock that never go backwards."""

    def __init__(self, clock: MediaClock) -> None:
        self._clock = clock
        self._last = float("-inf")

    def captured_at(self, timestamp_ns: int) -> float:
        """Return the capture time in seconds, later than every one before it."""
        self._last = max(believed(timestamp_ns, self._clock.now(), 0.0), self._last + _TICK)
        return self._last


class _Waiting(NamedTuple):
    """The newest picture, not read yet."""

    video: Video
    sequence: int
    captured_at: float
    is_whole: Callable[[], bool] | None


class EngineVideo:
    """The pictures of the connected engine, as a `MediaSource`; the newest replaces one that still waits.

    Without an engine there are no pictures, and with the next engine they go on: to a reader that is a gap, never an
    end. While it is not open there is no demand, and pictures that arrive all the same are dropped, as are those that
    were drawn before it was opened.

    Attributes:
        received: number of pictures that arrived.
        dropped: number of pictures that a newer one replaced before they were read, or that were overwritten in a ring
            before or during reading.
        last_at: when the last picture of the connected engine came, in seconds of the media clock.
        memory: memory that pictures are received into.

    Args:
        clock: the media clock.
        demand: counts this source as a consumer while it is open.
    """

    def __init__(self, clock: MediaClock, demand: PictureDemand) -> None:
        self.received = 0
        self.dropped = 0
        self.last_at: float | None = None
        self.memory = PictureMemory()
        self._clock = clock
        self._demand = demand
        self._timestamps = Timestamps(clock)
        self._first_sequence = 0
        self._next_sequence = 0
        self._waiting: _Waiting | None = None
        self._arrived = asyncio.Event()
        self._open = False

    def engine_arrived(self) -> None:
        """Note a connected engine, which counts its pictures from zero; the numbers here continue."""
        self._first_sequence = self._next_sequence
        self.last_at = None

    def engine_gone(self) -> None:
        """Note that the engine is disconnected, and free the memory for its pictures."""
        self.memory.clear()

    def count_lost(self) -> None:
        """Count a picture that a later one has overwritten in the ring."""
        self.count_received()
        self.dropped += self._open

    def count_received(self) -> None:
        """Count a picture that the engine has encoded, and that takes another way."""
        self.received += 1
        self.last_at = self._clock.now()

    def put(self, video: Video, is_whole: Callable[[], bool] | None = None) -> None:
        """Add a picture from the link; never waits.

        Pixels that the engine may overwrite are copied when the picture is read; `is_whole` then says if it did not.
        """
        self.received += 1
        self.last_at = self._clock.now()
        sequence = self._first_sequence + video.sequence
        self._next_sequence = sequence + 1
        captured_at = self._timestamps.captured_at(video.timestamp_ns)
        if self._open and not self._demand.is_stale(captured_at):
            self.dropped += self._waiting is not None
            self._waiting = _Waiting(video, sequence, captured_at, is_whole)
            self._arrived.set()

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawVideo]]:
        """Read the pictures that are drawn from now on."""
        self._open = True
        try:
            with self._demand.wanted():
                yield self._pictures()
        finally:
            self._open, self._waiting = False, None

    async def _pictures(self) -> AsyncIterator[RawVideo]:
        while True:
            await self._arrived.wait()
            self._arrived.clear()
            picture = self._next()
            if picture is not None:
                yield picture
            # Waiting for the next picture must not keep the memory of this one.
            del picture

    def _next(self) -> RawVideo | None:
        """Return the picture that waits, in memory of its own."""
        if self._waiting is None:
            return None
        (video, sequence, captured_at, is_whole), self._waiting = self._waiting, None
        picture = raw_video(video, sequence, captured_at, self.memory.allocate, lent=is_whole is not None)
        if is_whole is None or is_whole():
            return picture
        self.dropped += 1
        return None
