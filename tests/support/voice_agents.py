"""A visitor who whistles to an agent, what a viewer hears of the avatar that speaks for it, and agents as processes."""

import asyncio
import re
import signal
import sys
from asyncio.subprocess import PIPE, Process
from collections import deque
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_media import Media
from openrois_media.client.stream import News
from openrois_streaming.source.source import SAMPLE_RATE, RawAudio

from openrois.client import Client
from openrois.types.codes import Purpose
from tests.support.loopback import PATIENCE
from tests.support.operated import operated_avatar
from tests.support.packages import ROOT
from tests.support.sounds import paced, tone

__all__ = ["Ear", "Mouth", "end_agent", "hear_parrot", "hearing", "running_agent"]

_LOUD = 1_000
_NEAR = 120
"""Hz by which the pitch of a short block may be wrong."""
_PAUSE = 0.5
"""Seconds without sound that are between two tones, and not what a busy machine lost of one."""
_QUIET_BLOCKS = 30
"""Blocks without sound, 20 ms each, likewise."""


@dataclass
class Heard:
    """A tone that was heard, from its first to its last moment, as it was captured."""

    pitch: float
    began: float
    ended: float


class Ear:
    """Measures the tones of a body by capture times: what a viewer loses or stretches on a busy machine counts whole.

    Attributes:
        heard: each tone, the first one first.
        quiet: blocks without sound since the last one with it.
    """

    def __init__(self) -> None:
        self.heard: list[Heard] = []
        self.quiet = -1
        self._news = News()

    @property
    def loud(self) -> float:
        """Seconds of all tones."""
        return sum(each.ended - each.began for each in self.heard)

    def seconds(self, pitch: float) -> float:
        """Return the seconds of the tones of a pitch."""
        return sum(each.ended - each.began for each in self.heard if _is_near(each.pitch, pitch))

    async def listen(self, media: Media, microphone: str) -> None:
        """Receive the sound until this is cancelled."""
        async with media.blocks(microphone) as blocks:
            async for block in blocks:
                sound = block.samples[:, 0].astype(int)
                (places,) = np.nonzero(np.abs(sound) > _LOUD)
                if len(places) > len(sound) / 4:
                    first, last = int(places[0]), int(places[-1]) + 1
                    crossings = np.count_nonzero(np.diff(np.signbit(sound[first:last])))
                    pitch = float(crossings) / 2 / (last - first) * SAMPLE_RATE
                    self._add(pitch, block.local_time + first / SAMPLE_RATE, block.local_time + last / SAMPLE_RATE)
                else:
                    self.quiet = 0 if len(places) else self.quiet + 1
                self._news.notify()

    def _add(self, pitch: float, began: float, ended: float) -> None:
        self.quiet = 0
        latest = self.heard[-1] if self.heard else None
        if latest is not None and _is_near(latest.pitch, pitch) and began - latest.ended < _PAUSE:
            latest.ended = max(latest.ended, ended)
        else:
            self.heard.append(Heard(pitch, began, ended))

    async def hears(self) -> None:
        """Wait until the first block has come, loud or not."""
        await self._news.until(lambda: self.quiet >= 0)

    async def until_loud(self, seconds: float) -> None:
        """Wait until so much sound was received."""
        await self._news.until(lambda: self.loud >= seconds)

    async def until_quiet(self) -> None:
        """Wait until nothing is heard any more, of what has begun to be heard."""
        await self._news.until(lambda: self.loud and self.quiet >= _QUIET_BLOCKS)


def _is_near(pitch: float, other: float) -> bool:
    return abs(pitch - other) < _NEAR


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
        silence = np.zeros(SAMPLE_RATE // 50, np.int16)

        def next_block(_number: int) -> NDArray[np.int16]:
            if not self._blocks:
                self._quiet.set()
            return (self._blocks.popleft() if self._blocks else silence)[:, np.newaxis]

        yield paced(next_block)


@asynccontextmanager
async def running_agent(*words: str) -> AsyncIterator[Process]:
    """Run a program of Python, which is asked to end at the end of the block.

    Raises:
        AssertionError: it has not ended well.
    """
    process = await asyncio.create_subprocess_exec(sys.executable, *words, stdout=PIPE)
    try:
        yield process
    finally:
        status = await end_agent(process)
        assert status == 0, f"the agent has ended with status {status}"


async def end_agent(process: Process, patience: float = PATIENCE) -> int:
    """Ask a process to end, by SIGINT, and return its exit status.

    Raises:
        AssertionError: it had to be killed.
    """
    if process.returncode is None:
        process.send_signal(signal.SIGINT)
    try:
        async with asyncio.timeout(patience):
            return await process.wait()
    except TimeoutError:
        raise AssertionError(f"the agent was killed: it went on for {patience:g} s after SIGINT") from None
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


async def hear_parrot(folder: Path, example: str, *, gateway_leaves: bool) -> None:
    """Whistle to an example that repeats what it hears, as a person runs it, hear it through an avatar, and end it.

    Args:
        folder: for the avatar.
        example: name of a file in `docs/examples`.
        gateway_leaves: whether gateway and avatar are gone before the example is asked to end.
    """
    async with AsyncExitStack() as house, asyncio.timeout(3 * PATIENCE):
        gateway, _ = await house.enter_async_context(operated_avatar(folder))
        url = gateway.url.replace("http", "ws")
        async with running_agent(str(ROOT / "docs/examples" / example), "avatar", url) as process:
            await _hear_answer(process, url)
            if gateway_leaves:
                await house.aclose()


async def _hear_answer(process: Process, url: str) -> None:
    assert process.stdout is not None
    mouth = Mouth()
    async with (
        Client(url) as client,
        Media(client) as media,
        hearing(media) as ear,
        media.send(microphone=mouth, consent=[Purpose.AGENT]),
    ):
        # The program may not listen yet: it is spoken to until it has heard.
        line = asyncio.ensure_future(process.stdout.readline())
        while not line.done():
            mouth.say(500, 0.6)
            await mouth.until_said()
            await asyncio.wait({line}, timeout=2)
        # It may have begun to listen in the middle of a tone.
        heard = re.fullmatch(r"(\d\.\d) s of sound\n", (await line).decode())
        assert heard
        assert 0 < float(heard[1]) < 1
        await ear.until_loud(0.05)
        assert ear.heard[0].pitch == pytest.approx(500, abs=100)
