"""What is heard of an avatar through which an agent speaks, as a viewer receives it."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import numpy as np
from numpy.typing import NDArray
from openrois_media import Media
from openrois_media.client.stream import News

__all__ = ["Ear", "hearing", "tone"]

_LOUD = 1_000
_QUIET_BLOCKS = 10
"""Blocks without sound, 20 ms each, that no gap between two packets has."""


def tone(seconds: float, rate: int, pitch: float = 300) -> NDArray[np.int16]:
    """Return a tone, mono."""
    wave = np.sin(2 * np.pi * pitch * np.arange(round(seconds * rate)) / rate)
    return np.asarray(wave * 16_000, np.int16)


class Ear:
    """Measures the sound of a body.

    Attributes:
        loud: seconds of sound that were received.
        quiet: blocks without sound since the last one with it.
    """

    def __init__(self) -> None:
        self.loud = 0.0
        self.quiet = -1
        self._news = News()

    async def listen(self, media: Media, microphone: str) -> None:
        """Receive the sound until this is cancelled."""
        async with media.blocks(microphone) as blocks:
            async for block in blocks:
                loud = int(np.count_nonzero(np.abs(block.samples[:, 0].astype(int)) > _LOUD))
                self.quiet = 0 if loud else self.quiet + 1
                # Of a tone of 300 Hz so much is louder than that.
                self.loud += len(block.samples) / block.sample_rate if loud > len(block.samples) / 2 else 0.0
                self._news.notify()

    async def hears(self) -> None:
        """Wait until the first block has come, loud or not."""
        await self._news.until(lambda: self.quiet >= 0)

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
