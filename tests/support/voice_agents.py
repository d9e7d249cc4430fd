"""A visitor who whistles to an agent, and what a viewer hears of the avatar through which it speaks."""

import asyncio
import itertools
from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import numpy as np
from numpy.typing import NDArray
from openrois_media import Media
from openrois_media.client.stream import News
from openrois_streaming.clock import SystemClock
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio

__all__ = ["Ear", "Mouth", "hearing", "tone"]

_LOUD = 1_000
_PAUSE = 0.15
"""Seconds without sound that are between two tones, and not in one of them."""
_QUIET_BLOCKS = 10
"""Blocks without sound, 20 ms each, that no gap between two packets has."""


def tone(seconds: float, rate: int, pitch: float = 300) -> NDArray[np.int16]:
    """Return a tone, mono."""
    wave = np.sin(2 * np.pi * pitch * np.arange(round(seconds * rate)) / rate)
    return np.asarray(wave * 16_000, np.int16)


class Ear:
    """Measures the sound of a body by its capture times: what a busy machine's viewer loses or stretches counts whole.

    Attributes:
        loud: seconds of sound that were received, pauses left out.
        quiet: blocks without sound since the last one with it.
    """

    def __init__(self) -> None:
        self.loud = 0.0
        self.quiet = -1
        self._latest = float("-inf")
        """When the last block with sound ended."""
        self._news = News()

    async def listen(self, media: Media, microphone: str) -> None:
        """Receive the sound until this is cancelled."""
        async with media.blocks(microphone) as blocks:
            async for block in blocks:
                loud = np.count_nonzero(np.abs(block.samples[:, 0].astype(int)) > _LOUD)
                # Of a tone more than half is so loud.
                if loud > len(block.samples) / 2:
                    self._count(block.local_time, len(block.samples) / block.sample_rate)
                else:
                    self.quiet = 0 if loud else self.quiet + 1
                self._news.notify()

    def _count(self, began: float, seconds: float) -> None:
        ended = began + seconds
        self.loud += seconds if began - self._latest > _PAUSE else max(0.0, ended - self._latest)
        self._latest = max(self._latest, ended)
        self.quiet = 0

    async def hears(self) -> None:
        """Wait until the first block has come, loud or not."""
        await self._news.until(lambda: self.quiet >= 0)

    async def until_loud(self, seconds: float) -> None:
        """Wait until so much sound was received."""
        await self._news.until(lambda: self.loud >= seconds)

    async def until_quiet(self) -> None:
        """Wait until nothing is heard any more, of what has begun to be heard."""
        await self._news.until(lambda: self.loud and self.quiet >= _QUIET_BLOCKS)


@asynccontextmanager
async def hearing(media: Media, microphone: str = "avatar/audio_streaming") -> AsyncIterator[Ear]:
    """Hear a body; what it says before this begins would be missed."""
    ear = Ear()
    listening = asyncio.create_task(ear.listen(media, microphone))
    try:
        await ear.hears()
        yield ear
    finally:
        listening.cancel()
        await asyncio.wait({listening})


class Mouth:
    """The microphone of a visitor, a source: silence, but for the tones that it is told to make."""

    def __init__(self) -> None:
        self._blocks: deque[NDArray[np.int16]] = deque()
        self._quiet = asyncio.Event()

    def say(self, pitch: float, seconds: float) -> None:
        """Make a tone, behind those that are being made."""
        self._quiet.clear()
        sound = tone(seconds, SAMPLE_RATE, pitch)
        size = SAMPLE_RATE // 50
        self._blocks.extend(sound[first : first + size] for first in range(0, len(sound) // size * size, size))

    def hush(self) -> None:
        """Make no tone any more."""
        self._blocks.clear()

    async def until_said(self) -> None:
        """Wait until all tones have been sent."""
        await self._quiet.wait()

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawAudio]]:
        """Open it, as a source."""
        yield self._sound()

    async def _sound(self) -> AsyncIterator[RawAudio]:
        clock = SystemClock()
        began = clock.now()
        silence = np.zeros(SAMPLE_RATE // 50, np.int16)
        for number in itertools.count():
            due = began + number * 0.02
            await asyncio.sleep(max(0.0, due - clock.now()))
            if not self._blocks:
                self._quiet.set()
            block = self._blocks.popleft() if self._blocks else silence
            yield RawAudio(block[:, np.newaxis], due)
