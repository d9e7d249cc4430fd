"""Microphone of an application as a source: played out in a thread while the source is open."""

import asyncio
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Protocol, Self

from openrois_streaming.clock import MediaClock
from openrois_streaming.receive.decoders import OpusDecoder
from openrois_streaming.receive.playout import BLOCK, Block, Playout, PlayoutFigures, SoundPacket
from openrois_streaming.receive.remote_time import CaptureTime
from openrois_streaming.receive.worker import Handover, Worker
from openrois_streaming.source.source import SAMPLE_RATE, ReceivedAudio

_BLOCKS_WAITING = 20
# A thread that is later than this does not catch up: the playout skips what it missed.
_LATE = 0.1
# Interval of checks whether the first packet is due.
_BEGINNING = 0.001


class AudioSource:
    """`MediaSource` of sound, stereo, in blocks that come at a steady pace from the first packet on.

    `captured` turns the timestamp of a block into a capture time; it is called in the thread. `longest` is how many
    samples a block has at most.
    """

    def __init__(self, clock: MediaClock, captured: Callable[[int, float], CaptureTime], longest: int = BLOCK) -> None:
        self._clock = clock
        self._captured = captured
        self.longest = longest
        self._playing: _Opening | None = None
        self._ended = False
        self.decoded = 0
        """Number of blocks played."""
        self.dropped = 0
        """Number of blocks not read in time."""

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[ReceivedAudio]]:
        """Play while the context lasts; the iterator ends when the sender is gone for good.

        Raises:
            RuntimeError: it is open already.
        """
        if self._playing is not None:
            raise RuntimeError("the source is open already: close it first")
        blocks = Handover[ReceivedAudio](_BLOCKS_WAITING)
        playing = self._playing = _Playing(self, blocks)
        try:
            async with Worker("decode audio", playing.run, playing.stop, blocks.end_input):
                if self._ended:
                    blocks.end_input()
                yield blocks
        finally:
            self._playing = None
            self.dropped += blocks.lost

    def offer(self, packet: SoundPacket, arrival: float) -> None:
        """Offer a packet that came at `arrival`; it is played while the source is open."""
        if self._playing is not None:
            self._playing.offer(packet, arrival)

    def end_input(self) -> None:
        """End the input: no more packets will be offered."""
        self._ended = True
        if self._playing is not None:
            self._playing.end_input()

    @property
    def delay(self) -> float:
        """Playout delay of the present sound in seconds; 0 while the source is closed."""
        return 0.0 if self._playing is None else self._playing.delay

    @property
    def figures(self) -> PlayoutFigures:
        """Changes to the sound since the source was opened."""
        return PlayoutFigures() if self._playing is None else self._playing.playout.figures

    def now(self) -> float:
        """Return the time of the media clock."""
        return self._clock.now()

    def date(self, block: Block, now: float) -> ReceivedAudio:
        """Return the block as the source yields it."""
        self.decoded += 1
        return ReceivedAudio(block.samples, *self._captured(block.timestamp, now))


class LoopAudioSource(AudioSource):
    """`AudioSource` that is played in the event loop, when its reader asks for the next block.

    It takes half of the time of a thread, which has to be woken for each block and has to wake the reader. It suits a
    loop that is the application's own; a loop that is held up plays late, and skips what it has missed.
    """

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[ReceivedAudio]]:
        """Play while the context lasts; the iterator ends when the sender is gone for good.

        Raises:
            RuntimeError: it is open already.
        """
        if self._playing is not None:
            raise RuntimeError("the source is open already: close it first")
        playing = self._playing = _PlayingInLoop(self)
        try:
            if self._ended:
                playing.end_input()
            yield playing
        finally:
            self._playing = None

    async def sleep_until(self, deadline: float) -> None:
        """Wait until the media clock has reached `deadline`."""
        await self._clock.sleep_until(deadline)


class _Opening(Protocol):
    """One opening of the source."""

    playout: Playout
    delay: float

    def offer(self, packet: SoundPacket, arrival: float) -> None: ...

    def end_input(self) -> None: ...


class _PlayingInLoop:
    """One opening of the source, as its iterator: each step waits until the next block is due."""

    def __init__(self, source: LoopAudioSource) -> None:
        self.delay = 0.0
        self.playout = Playout(OpusDecoder(), source.longest)
        self._source = source
        self._due: float | None = None
        self._ended = False
        self._news = asyncio.Event()

    def offer(self, packet: SoundPacket, arrival: float) -> None:
        self.playout.add(packet, arrival)
        self._news.set()

    def end_input(self) -> None:
        self._ended = True
        self._news.set()

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> ReceivedAudio:
        await self._news.wait()
        if self._due is None:
            self._due = self._source.now()
        while not self._ended:
            await self._source.sleep_until(self._due)
            now = self._source.now()
            if now - self._due > _LATE:
                self._due = now
            block = self.playout.play(self._due)
            self.delay = self.playout.played_delay
            if block is not None:
                self._due += len(block.samples) / SAMPLE_RATE
                return self._source.date(block, now)
            self._due = now + _BEGINNING
        raise StopAsyncIteration


class _Playing:
    """One opening of the source: its thread and its playout buffer."""

    def __init__(self, source: AudioSource, blocks: Handover[ReceivedAudio]) -> None:
        self.blocks = blocks
        self.delay = 0.0
        self._source = source
        # Both threads use the following attributes, under this condition.
        self._changed = threading.Condition()
        self.playout = Playout(OpusDecoder(), source.longest)
        self._arrived = self._stopping = False

    def offer(self, packet: SoundPacket, arrival: float) -> None:
        with self._changed:
            self.playout.add(packet, arrival)
            if not self._arrived:
                self._arrived = True
                self._changed.notify()

    def end_input(self) -> None:
        self.blocks.end_input()

    def stop(self) -> None:
        with self._changed:
            self._stopping = True
            self._changed.notify()

    def run(self) -> None:
        with self._changed:
            self._changed.wait_for(lambda: self._arrived or self._stopping)
        due = self._source.now()
        while self._wait_until(due):
            now = self._source.now()
            if now - due > _LATE:
                due = now
            with self._changed:
                block = self.playout.play(due)
                self.delay = self.playout.played_delay
            if block is None:
                due = now + _BEGINNING
            else:
                self.blocks.put(self._source.date(block, now))
                due += len(block.samples) / SAMPLE_RATE

    def _wait_until(self, due: float) -> bool:
        """Wait until `due`; whether to go on."""
        with self._changed:
            while not self._stopping and (left := due - self._source.now()) > 0:
                self._changed.wait(left)
            return not self._stopping
