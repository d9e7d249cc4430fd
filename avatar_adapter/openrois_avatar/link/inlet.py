"""Where an engine's pictures enter the media plane: a source that outlives the engine and its connection."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Final, NamedTuple

from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import RawVideo

from openrois_avatar.link.demand import PictureDemand
from openrois_avatar.link.memory import PictureMemory
from openrois_avatar.link.picture import raw_video
from openrois_avatar.link.protocol import Video

MAX_AGE: Final = 1.0
"""Seconds. What claims to be older was stamped by another clock than ours; so was a picture from the future."""
MAX_AHEAD: Final = 0.5
"""Seconds that sound may be sent ahead of its time."""
_TICK: Final = 0.001


def believed(timestamp_ns: int, now: float, ahead: float) -> float:
    """An engine's timestamp in seconds of the media clock, which is CLOCK_MONOTONIC too.

    One that cannot be true (older than `MAX_AGE`, or more than `ahead` seconds later than now) becomes `now`, the time
    of arrival.
    """
    claimed = timestamp_ns / 1e9
    return claimed if now - MAX_AGE <= claimed <= now + ahead else now


class Timestamps:
    """Turns the timestamps of an engine's pictures into times of the media clock that never go backwards."""

    def __init__(self, clock: MediaClock) -> None:
        self._clock = clock
        self._last = float("-inf")

    def captured_at(self, timestamp_ns: int) -> float:
        """The time of capture in seconds, later than every one before it."""
        self._last = max(believed(timestamp_ns, self._clock.now(), 0.0), self._last + _TICK)
        return self._last


class _Waiting(NamedTuple):
    """A picture that nobody has read yet."""

    video: Video
    sequence: int
    captured_at: float
    is_whole: Callable[[], bool] | None


class EngineVideo:
    """The pictures of whichever engine is connected, as a `MediaSource`; the newest replaces one that still waits.

    While no engine is connected there are no pictures, and when one comes back they go on: to a reader that is a gap,
    never an end. While it is not open no pictures are wanted, and those that come all the same are received and
    forgotten; nothing is given out that was drawn before it was opened.

    `received` counts the pictures that arrived, `dropped` those that a newer one replaced before they were read, and
    those of a ring that were overwritten before, or while they were.
    `last_at` is when the last one came from the engine that is connected now, in seconds of the media clock.
    `memory` is what pictures are received into.

    Args:
        clock: the media clock.
        demand: what is told that pictures are wanted.
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

    def begin(self) -> None:
        """A new engine counts its pictures from zero; ours go on where the last engine's ended."""
        self._first_sequence = self._next_sequence
        self.last_at = None

    def end(self) -> None:
        """No engine is there any more, and no memory is kept for its pictures."""
        self.memory.clear()

    def lost(self) -> None:
        """A picture has come that is not there any more: a later one has its place in the ring."""
        self.passed_by()
        self.dropped += self._open

    def passed_by(self) -> None:
        """A picture has come that takes another way: the engine has encoded it."""
        self.received += 1
        self.last_at = self._clock.now()

    def put(self, video: Video, is_whole: Callable[[], bool] | None = None) -> None:
        """Take a picture from the link; never waits.

        Pixels that others may write into are copied when the picture is read; `is_whole` then tells if nobody did.
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
            # The one who waits for the next picture does not keep the memory of this one.
            del picture

    def _next(self) -> RawVideo | None:
        """The picture that waits, in memory of its own."""
        if self._waiting is None:
            return None
        (video, sequence, captured_at, is_whole), self._waiting = self._waiting, None
        picture = raw_video(video, sequence, captured_at, self.memory.take, lent=is_whole is not None)
        if is_whole is None or is_whole():
            return picture
        self.dropped += 1
        return None
