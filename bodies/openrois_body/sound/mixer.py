"""The body's sound: engine sound and speech, mixed on the media clock."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio

from openrois_body.sound.engine_sound import BLOCK, EngineSound, SoundLag
from openrois_body.sound.playback import Playback

BLOCKS_PER_SECOND: Final = SAMPLE_RATE // BLOCK
LEAD_BLOCKS: Final = 2
"""Blocks between now and the earliest start of speech: 40 to 60 ms in which the engine learns how to move the mouth."""
KEPT_BLOCKS: Final = 10
"""Blocks, 0.2 s, that a late reader still gets."""
MAX_QUEUED: Final = 32
"""Speeches that may wait for their turn."""


class SoundBusy(Exception):
    """Too many speeches wait."""


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
        self._playbacks: deque[Playback] = deque()
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

    def play(self) -> Playback:
        """Play what is pushed from now on after all speeches before it, 40 to 60 ms from now at the earliest.

        Raises:
            SoundBusy: `MAX_QUEUED` speeches wait already.
            ValueError: the end of a speech before it is open.
        """
        playback = Playback(self, self._place())
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
