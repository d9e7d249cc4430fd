"""A microphone that is fed by hand, the senses behind it, and a recogniser with scripted results."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress

import numpy as np
from numpy.typing import NDArray
from openrois_body.hearing.recognizer import Expectation, RecognizerFailed, Transcriber
from openrois_media.devices import Microphone
from openrois_streaming.source.source import RawAudio

from tests.support.streaming import FedSource, VirtualClock, settle


class ScriptedRecognizer:
    """Returns the results in `understands`, in English and German, and records the expected phrases."""

    languages = ("en", "de")
    destination = ""

    def __init__(self) -> None:
        self.understands: tuple[str, ...] = ("hello", "hollow")
        self.expected: list[Expectation] = []
        self.heard: list[int] = []
        self.opened = self.closed = 0
        self.failures = 0
        """How many of the next calls fail."""
        self.installed = True
        self.held: asyncio.Event | None = None
        """Its answers wait for this, if set."""
        self._samples = 0

    def available(self) -> tuple[bool, str]:
        return self.installed, "" if self.installed else "install it"

    def refusal(self, expected: Expectation) -> str:
        return "no such grammar" if expected.grammar == "unknown" else ""

    @asynccontextmanager
    async def open(self) -> AsyncIterator[Transcriber]:
        if not self.installed:
            raise RecognizerFailed("install it")
        self.opened += 1
        try:
            yield self
        finally:
            self.closed += 1

    async def begin(self, expected: Expectation) -> None:
        await self._answer()
        self.expected.append(expected)
        self._samples = 0

    async def hear(self, samples: NDArray[np.int16]) -> str:
        await self._answer()
        self._samples += len(samples)
        return self.understands[0][: 1 + self._samples // 8000] if self.understands else ""

    async def finish(self, guess: Callable[[str], None]) -> tuple[str, ...]:
        await self._answer()
        self.heard.append(self._samples)
        return self.understands

    async def _answer(self) -> None:
        if self.held is not None:
            await self.held.wait()
        if self.failures:
            self.failures -= 1
            raise RecognizerFailed("it broke")


class Listened:
    """A microphone of an operator, fed by hand in blocks of 10 ms."""

    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.microphone = Microphone(self.clock)
        self._voice: FedSource[RawAudio] = FedSource()

    @asynccontextmanager
    async def plugged(self, *running: asyncio.Future[None]) -> AsyncIterator[None]:
        """Run the microphone, plugged in, and end what is `running` besides."""
        self.plug()
        tasks = (asyncio.ensure_future(self.microphone.listen()), *running)
        await settle()
        yield
        for task in tasks:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task

    def plug(self) -> None:
        self.microphone.inlet.plug("s", self._voice)

    def unplug(self) -> None:
        self.microphone.inlet.unplug("s")

    async def say(self, sound: NDArray[np.int16]) -> None:
        """Play 48 kHz stereo."""
        for start in range(0, len(sound), 480):
            await self._voice.feed(RawAudio(sound[start : start + 480], self.clock.now()))
            await self.clock.advance(0.01)
