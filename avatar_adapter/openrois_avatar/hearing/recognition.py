"""What the operator says, written down: one utterance after the other, by a recogniser that may hang or die."""

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock

from openrois.aio.listeners import Listeners
from openrois.transport.backoff import Backoff
from openrois_avatar.hearing.downsample import SPEECH_RATE
from openrois_avatar.hearing.hearing import Hearing
from openrois_avatar.hearing.recognizer import Expectation, RecognizerFailed, SpeechRecognizer, Transcriber
from openrois_avatar.sensing.figures import SenseFigures

__all__ = ["Recognition", "Utterance"]

WAITING: Final = 3
"""Utterances that may wait; of more, the oldest is lost: who is understood too late is not understood."""
ATTEMPTS: Final = 2
"""How often an utterance is tried that a recogniser fails at."""
_PART: Final = SPEECH_RATE
"""Samples that are given to a recogniser at a time, at most."""
_LOUDNESS: Final = 2000.0
"""Root mean square to which speech is brought: acoustic models know voices that are near."""
_LOUDER: Final = 30.0
"""How much louder it is made, at most."""

_log = logging.getLogger(__name__)


@dataclass(eq=False)
class Utterance:
    """Speech as it comes, in parts of 16 kHz; what is expected was decided when it began."""

    began_at: float
    expected: Expectation
    gain: float = 1.0
    parts: list[NDArray[np.int16]] = field(default_factory=list)
    ended_at: float | None = None
    attempts: int = 0
    changed: asyncio.Event = field(default_factory=asyncio.Event)

    def add(self, samples: NDArray[np.int16]) -> None:
        """Take what comes next. The first part, which is that by which it was noticed, decides how loud it is made."""
        if not self.parts:
            loudness = float(np.sqrt(np.mean(samples.astype(np.float64) ** 2))) if len(samples) else 0.0
            self.gain = min(_LOUDER, max(1.0, _LOUDNESS / max(loudness, 1.0)))
        self.parts.append(np.clip(samples * self.gain, -32_768, 32_767).astype(np.int16))
        self.changed.set()

    def end(self, at: float) -> None:
        """It ended."""
        self.ended_at = at
        self.changed.set()


class Recognition:
    """Writes down what is said, while it is wanted. `run` must run for that.

    Args:
        hearing: tells who speaks.
        recognizer: writes down.
        clock: the media clock.
    """

    def __init__(self, hearing: Hearing, recognizer: SpeechRecognizer, clock: MediaClock) -> None:
        self.expected: Callable[[], Expectation] = lambda: Expectation(recognizer.languages[:1])
        """Says what is expected of the next utterance."""
        self.guessed: Listeners[str] = Listeners()
        """Are told what is understood of an utterance that goes on, when that is something else than before."""
        self.recognized: Listeners[tuple[str, ...], float] = Listeners()
        """Are told what may have been said, the likeliest first, and when that ended; speech that is not understood
        is not told."""
        self.failed: Listeners[str] = Listeners()
        """Are told why an utterance was not written down, or nothing can be, in a sentence for a person."""
        self.failure = ""
        """Why nothing can be written down now."""
        self.figures = SenseFigures(lost=0)
        self._hearing = hearing
        self._recognizer = recognizer
        self._clock = clock
        self._wanted_by: set[object] = set()
        self._leave: list[Callable[[], None]] = []
        self._current: Utterance | None = None
        self._tried: Utterance | None = None
        """The one that is being written down, if it was not lost meanwhile the first of those that wait."""
        self._waiting: deque[Utterance] = deque(maxlen=WAITING)
        self._changed = asyncio.Event()

    def want(self) -> Callable[[], None]:
        """Write down from now on; return what ends that, however often it is called."""
        key = object()
        self._wanted_by.add(key)
        if not self._leave:
            self._leave = [
                self._hearing.speech_began.add(self._begin),
                self._hearing.speech.add(self._hear),
                self._hearing.speech_ended.add(self._end),
                self._hearing.attend(),
            ]
            self._changed.set()
        return lambda: self._unwant(key)

    async def run(self) -> None:
        """Work for ever."""
        backoff = Backoff(first=0.1, factor=3.0, lasting=5.0)
        while True:
            await self._until(lambda: bool(self._leave))
            since = self._clock.now()
            try:
                async with self._recognizer.open() as transcriber:
                    await self._work(transcriber)
            except RecognizerFailed as error:
                self._fail(str(error))
                await self._clock.sleep_until(self._clock.now() + backoff.after(self._clock.now() - since))

    async def _work(self, transcriber: Transcriber) -> None:
        """Write down until nobody wants it any more."""
        self.failure = ""
        while True:
            await self._until(lambda: bool(self._waiting) or not self._leave)
            if not self._leave:
                return
            utterance = self._tried = self._waiting[0]
            utterance.attempts += 1
            await self._write_down(transcriber, utterance)
            self._done()

    async def _write_down(self, transcriber: Transcriber, utterance: Utterance) -> None:
        with self._spending():
            await transcriber.begin(utterance.expected)
        taken, guess = 0, ""
        while True:
            parts = utterance.parts[taken:]
            taken += len(parts)
            sound = np.concatenate([np.zeros(0, np.int16), *parts])
            for start in range(0, len(sound), _PART):
                with self._spending():
                    understood = await transcriber.hear(sound[start : start + _PART])
                if understood != guess and self._leave:
                    guess = understood
                    self.guessed.tell(guess)
            if taken == len(utterance.parts):
                if utterance.ended_at is not None:
                    break
                utterance.changed.clear()
                await utterance.changed.wait()
        with self._spending():
            candidates = await transcriber.end()
        self.figures.analysed += 1
        if candidates and self._leave:
            self.recognized.tell(candidates, utterance.ended_at)

    @contextmanager
    def _spending(self) -> Iterator[None]:
        """Count the time that a recogniser takes."""
        began = self._clock.now()
        try:
            yield
        finally:
            self.figures.seconds += self._clock.now() - began

    def _fail(self, reason: str) -> None:
        """Try the utterance once more that was tried, if there is one; else it is lost."""
        _log.warning("%s", reason)
        self.figures.failed += 1
        if self._tried is not None and self._tried.attempts < ATTEMPTS:
            self._tried = None
            return
        self._done()
        self.failure = reason if self._leave else ""
        self.failed.tell(reason)

    def _done(self) -> None:
        """The utterance that was tried is so no more; it may be lost already."""
        if self._waiting and self._waiting[0] is self._tried:
            self._waiting.popleft()
        self._tried = None

    def _unwant(self, key: object) -> None:
        self._wanted_by.discard(key)
        if self._wanted_by or not self._leave:
            return
        leave, self._leave = self._leave, []
        for each in leave:
            each()
        if self._current is not None:
            self._current.end(self._current.began_at)
            self._current = None
        self._waiting.clear()
        self.failure = ""
        self._changed.set()

    async def _until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            self._changed.clear()
            await self._changed.wait()

    def _begin(self, at: float) -> None:
        if len(self._waiting) == WAITING and self._waiting[0] is not self._tried:
            self.figures.lost = 1 + (self.figures.lost or 0)
        self._current = Utterance(at, self.expected())
        self._waiting.append(self._current)
        self._changed.set()

    def _hear(self, samples: NDArray[np.int16]) -> None:
        if self._current is not None:
            self._current.add(samples)

    def _end(self, at: float) -> None:
        if self._current is not None:
            self._current.end(at)
            self._current = None
