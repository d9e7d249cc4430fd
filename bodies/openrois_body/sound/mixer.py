"""The body's sound: engine sound and speech, mixed on the media clock."""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio

from openrois_body.sound.engine_sound import BLOCK, SEAM, EngineSound, SoundLag
from openrois_body.sound.open_playback import OpenPlayback, reach

BLOCKS_PER_SECOND: Final = SAMPLE_RATE // BLOCK
LEAD_BLOCKS: Final = 2
"""Blocks between now and the earliest start of speech: 40 to 60 ms in which the engine learns how to move the mouth."""
KEPT_BLOCKS: Final = 10
"""Blocks, 0.2 s, that a late reader still gets."""
MAX_QUEUED: Final = 32
"""Speeches that may wait for their turn."""

_FALL: Final = 1 - (np.arange(SEAM, dtype=np.float32) + 0.5) / SEAM


class SoundBusy(Exception):
    """Too many speeches wait."""


class Playback:
    """A speech with its place in time. Times are seconds of the media clock and change only by `stop`.

    It advances by the clock, with or without listeners.
    """

    def __init__(self, sound: BodySound, samples: NDArray[np.int16], first: int) -> None:
        """`first` is the number of the first sample since the clock's zero. Use `BodySound.play`."""
        self._sound = sound
        self._samples = samples
        self._first = first
        self._cut: int | None = None
        self._stopped = asyncio.Event()

    @property
    def start(self) -> float:
        """The due time of the first sample."""
        return self._first / SAMPLE_RATE

    @property
    def start_ns(self) -> int:
        """`start` in nanoseconds of CLOCK_MONOTONIC, as the engine link wants it."""
        return round(self._first * 1_000_000_000 / SAMPLE_RATE)

    @property
    def end(self) -> float:
        """The time when the last sample has been due."""
        return self.last / SAMPLE_RATE

    @property
    def last(self) -> int:
        """The number of the sample after its last one."""
        end = self._first + len(self._samples)
        if self._cut is None:
            return end
        return min(end, self._cut + SEAM) if self._cut > self._first else self._first

    @property
    def is_settled(self) -> bool:
        """Whether its end is known, as it always is."""
        return True

    def is_over(self, begin: int) -> bool:
        """Tell whether nothing of it is heard from sample `begin` on."""
        return self.last <= begin

    @property
    def heard(self) -> int:
        """The number of samples that are heard, up to `stop`; those of the fade-out do not count."""
        return len(self._samples) if self._cut is None else max(0, self._cut - self._first)

    async def reach(self, moment: float) -> bool:
        """Wait until a moment of the media clock, or until `stop`; any number of tasks may wait.

        Returns:
            True if the moment came, False if it was stopped.
        """
        return await reach(self._sound.clock, moment, self._stopped)

    def stop(self) -> None:
        """Fade out within the next 5 ms that are not handed out yet; without effect after the end."""
        cut = self._sound.next_sample()
        if cut < self.last and self._cut is None:
            self._cut = cut
        self._stopped.set()

    def mix_into(self, mixed: NDArray[np.int32], begin: int) -> None:
        """Add the samples from `begin` on to `mixed`, shape (n, channels)."""
        first, last = max(begin, self._first), min(begin + len(mixed), self.last)
        if first >= last:
            return
        part = self._samples[first - self._first : last - self._first].astype(np.int32)
        if self._cut is not None and last > self._cut:
            fading = part[max(0, self._cut - first) :]
            reached = max(first, self._cut) - self._cut
            fading[:] = fading * _FALL[reached : reached + len(fading)]
        mixed[first - begin : last - begin] += part[:, np.newaxis]


class BodySound:
    """The body's sound as one `MediaSource`: blocks of 20 ms at 48 kHz, each when its first sample is due.

    The blocks lie on a grid that the media clock alone gives (multiples of 20 ms), so opening, closing and late readers
    do not move anything: speech is consumed by time, not by readers. A reader that is late by up to 0.2 s loses
    nothing, one that is later misses blocks. Without an engine, and without speech, there is silence at the same pace.

    The engine's own sound is played at its timestamps. Where it comes too late for that, all blocks are delayed, still
    with their true times (`SoundLag`).

    Args:
        clock: the media clock, also the engine's.
        channels: 1 or 2.
    """

    def __init__(self, clock: MediaClock, channels: int = 1) -> None:
        self.clock = clock
        self._engine = EngineSound(channels)
        self._lag = SoundLag()
        self._playbacks: deque[Playback | OpenPlayback] = deque()
        self._next_block: int | None = None

    @property
    def lag(self) -> float:
        """Seconds of delay of each sample, because the engine's own sound comes late."""
        return self._lag.seconds

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawAudio]]:
        """Yield the blocks from now on; they do not end."""
        self._next_block = self._now() + 1
        self._engine.start(self._next_block * BLOCK)
        self._lag = SoundLag()
        try:
            async with aclosing(self._blocks(self._next_block)) as blocks:
                yield blocks
        finally:
            self._next_block = None

    def feed(self, sound: RawAudio) -> None:
        """Add engine sound of any length, in time or ahead of it; it is lost without a reader."""
        if self._next_block is not None:
            first = self._engine.put(sound.samples, sound.captured_at)
            now = self.clock.now()
            self._lag.arrived(now - first // BLOCK / BLOCKS_PER_SECOND, now)

    def play(self, samples: NDArray[np.int16]) -> Playback:
        """Play `samples` (mono, 48 kHz) after all speeches before them, 40 to 60 ms from now at the earliest.

        Raises:
            SoundBusy: `MAX_QUEUED` speeches wait already.
            ValueError: the end of a speech before it is open.
        """
        playback = Playback(self, samples, self._place())
        self._playbacks.append(playback)
        return playback

    def play_open(self) -> OpenPlayback:
        """Play what is pushed from now on after all speeches before it, 40 to 60 ms from now at the earliest.

        Raises:
            SoundBusy: `MAX_QUEUED` speeches wait already.
            ValueError: the end of a speech before it is open.
        """
        playback = OpenPlayback(self, self._place())
        self._playbacks.append(playback)
        return playback

    def earliest(self) -> int:
        """Return the number of the first sample of a speech that begins as soon as it may."""
        return (self._now() + 1 + LEAD_BLOCKS) * BLOCK

    def _place(self) -> int:
        """Return the number of the first sample of the next speech."""
        self._forget_before(self.next_sample())
        if not all(before.is_settled for before in self._playbacks):
            raise ValueError("the end of a speech before it is open: wait for its turn")
        if len(self._playbacks) >= MAX_QUEUED:
            raise SoundBusy(f"{MAX_QUEUED} speeches wait already, which is the limit; wait until one has ended")
        return max([self.earliest(), *(before.last for before in self._playbacks)])

    def next_sample(self) -> int:
        """Return the number, since the clock's zero, of the first sample that is not handed out yet."""
        following = self._now() + 1 if self._next_block is None else self._next_block
        return following * BLOCK

    def _now(self) -> int:
        """Return the number of the block that is due now."""
        return math.floor(self.clock.now() * BLOCKS_PER_SECOND)

    async def _blocks(self, number: int) -> AsyncGenerator[RawAudio, None]:
        while True:
            await self.clock.sleep_until(number / BLOCKS_PER_SECOND + self._lag.seconds)
            newest = math.floor((self.clock.now() - self._lag.seconds) * BLOCKS_PER_SECOND)
            number = max(number, newest - KEPT_BLOCKS)
            self._next_block = number + 1
            yield RawAudio(self._mix(number * BLOCK), number / BLOCKS_PER_SECOND)
            number += 1

    def _mix(self, begin: int) -> NDArray[np.int16]:
        self._forget_before(begin)
        mixed = self._engine.next_block(begin).astype(np.int32)
        for playback in self._playbacks:
            playback.mix_into(mixed, begin)
        return np.clip(mixed, -32_768, 32_767).astype(np.int16)

    def _forget_before(self, begin: int) -> None:
        """Drop the speeches that are handed out completely."""
        while self._playbacks and self._playbacks[0].is_over(begin):
            self._playbacks.popleft()
