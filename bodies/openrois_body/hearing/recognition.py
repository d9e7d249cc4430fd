"""Speech recognition: one utterance after the other, by a recogniser that may hang or die."""

import asyncio
import logging
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock
from openrois_streaming.source.downsample import SPEECH_RATE

from openrois.aio.listeners import Listeners
from openrois.transport.backoff import Backoff
from openrois_body.hearing.recognizer import Expectation, RecognizerFailed, SpeechRecognizer, Transcriber
from openrois_body.hearing.speech_detector import SpeechDetector
from openrois_body.hearing.voice_activity import PREROLL
from openrois_body.sensing.figures import SenseFigures

__all__ = ["Recognition", "Utterance"]

WAITING: Final = 3
"""Utterances that may wait; of more, the oldest is lost, as a late result is of no use."""
ATTEMPTS: Final = 2
"""Attempts at an utterance that a recogniser fails at."""
_PART: Final = SPEECH_RATE
"""Most samples that a recogniser gets at a time."""
_LOUDNESS: Final = 2000.0
"""Root mean square to which speech is amplified: acoustic models are made for near voices."""
_LOUDER: Final = 30.0
"""The largest amplification."""

_log = logging.getLogger(__name__)


class _Withheld(Exception):
    """An utterance must not be sent to the recogniser; the text says why, where a person has to know it."""


@dataclass(eq=False)
class Utterance:
    """Speech as it arrives, in parts of 16 kHz; its expectation was set when it began.

    `withheld`: a part of it must not be sent to the recogniser, and so none of it is.
    """

    began_at: float
    expected: Expectation
    sender: str = ""
    gain: float = 1.0
    parts: list[NDArray[np.int16]] = field(default_factory=list)
    ended_at: float | None = None
    attempts: int = 0
    withheld: bool = False
    changed: asyncio.Event = field(default_factory=asyncio.Event)

    def withhold(self) -> None:
        """Forget the sound: it must not be sent."""
        self.withheld = True
        self.parts.clear()
        self.changed.set()

    def add(self, samples: NDArray[np.int16]) -> None:
        """Add the next part. The first one, by which the speech was noticed, sets the amplification."""
        if self.withheld:
            return
        if not self.parts:
            loudness = float(np.sqrt(np.mean(samples.astype(np.float64) ** 2))) if len(samples) else 0.0
            self.gain = min(_LOUDER, max(1.0, _LOUDNESS / max(loudness, 1.0)))
        self.parts.append(np.clip(samples * self.gain, -32_768, 32_767).astype(np.int16))
        self.changed.set()

    def mark_ended(self, at: float) -> None:
        """Note when the utterance ended."""
        self.ended_at = at
        self.changed.set()


class Recognition:
    """Recognises utterances while a caller wants that. `run` has to run.

    Args:
        speech: tells when the operator speaks.
        recognizer: the backend.
        clock: the media clock.
        may_send: whether the sound of this very moment may be sent to the recogniser's `destination`. None: only where
            that is this machine.
        admits: tells whether what this sender said from that moment on may be recognised now, and announced.

    Both have to allow it; they are asked with each block of sound, before each request, and before a result is told.
    """

    def __init__(
        self,
        speech: SpeechDetector,
        recognizer: SpeechRecognizer,
        clock: MediaClock,
        may_send: Callable[[], bool] | None = None,
        admits: Callable[[str, float], bool] = lambda _sender, _began_at: True,
    ) -> None:
        self.expected: Callable[[], Expectation] = lambda: Expectation(recognizer.languages[:1])
        """Returns the expectation of the next utterance."""
        self.guessed: Listeners[str, str] = Listeners()
        """Called with each new partial result of an utterance that goes on, and with its sender."""
        self.recognized: Listeners[tuple[str, ...], float, str] = Listeners()
        """Called with the candidates of an utterance, the likeliest first, when it ended, and with its sender.

        `OTHER_SPEECH` is the only one of speech that a grammar has no sentence for.
        """
        self.failed: Listeners[str] = Listeners()
        """Called with a sentence for a person that says why an utterance, or every one, is not recognised."""
        self.failure = ""
        """Why speech cannot be recognised now; empty if it can."""
        self.figures = SenseFigures(lost=0)
        self._may_send = may_send or (lambda: not recognizer.destination)
        self._is_withholding = False
        """Whether the last utterance was withheld."""
        self._speech = speech
        self._recognizer = recognizer
        self._clock = clock
        self._admits = admits
        self._wanted_by: set[object] = set()
        self._leave: list[Callable[[], None]] = []
        self._current: Utterance | None = None
        self._tried: Utterance | None = None
        """The utterance that is being recognised; the first in the queue unless it was lost meanwhile."""
        self._waiting: deque[Utterance] = deque(maxlen=WAITING)
        self._changed = asyncio.Event()

    @property
    def destination(self) -> str:
        """Where sound is sent, as `https://host`; empty where it stays on this machine."""
        return self._recognizer.destination

    @property
    def withheld(self) -> str:
        """Why the sound of this moment is not sent to the recogniser, a sentence; empty if that rests on its sender."""
        if self._may_send():
            return ""
        return f"the person who speaks has not agreed that the sound is sent to {self.destination or 'a recogniser'}"

    def want(self) -> Callable[[], None]:
        """Recognise speech from now on; return a function that ends that, and may be called repeatedly."""
        key = object()
        self._wanted_by.add(key)
        if not self._leave:
            self._leave = [
                self._speech.sound_came.add(self._check_consent),
                self._speech.speech_began.add(self._begin_utterance),
                self._speech.speech.add(self._add_sound),
                self._speech.speech_ended.add(self._end_utterance),
                self._speech.attend(),
            ]
            self._changed.set()
        return lambda: self._unwant(key)

    async def run(self) -> None:
        """Recognise utterances until cancelled."""
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
        """Recognise utterances until no caller wants it any more."""
        self.failure = ""
        while True:
            await self._until(lambda: bool(self._waiting) or not self._leave)
            if not self._leave:
                return
            utterance = self._tried = self._waiting[0]
            utterance.attempts += 1
            try:
                await self._write_down(transcriber, utterance)
                self._is_withholding = False
            except _Withheld as withheld:
                if str(withheld) and not self._is_withholding:
                    self._is_withholding = True
                    self.failed.notify_all(str(withheld))
            self._done()

    async def _write_down(self, transcriber: Transcriber, utterance: Utterance) -> None:
        self._require_consent(utterance)
        with self._spending():
            await transcriber.begin(utterance.expected)
        taken, guess = 0, ""
        while True:
            self._require_consent(utterance)
            parts = utterance.parts[taken:]
            taken += len(parts)
            sound = np.concatenate([np.zeros(0, np.int16), *parts])
            for start in range(0, len(sound), _PART):
                self._require_consent(utterance)
                with self._spending():
                    understood = await transcriber.hear(sound[start : start + _PART])
                if understood != guess:
                    guess = understood
                    self._guess(utterance, guess)
            if taken == len(utterance.parts):
                if utterance.ended_at is not None:
                    break
                utterance.changed.clear()
                await utterance.changed.wait()
        self._require_consent(utterance)
        with self._spending():
            candidates = await transcriber.finish(partial(self._guess, utterance))
        self._require_consent(utterance)
        self.figures.analysed += 1
        if candidates and self._may_announce(utterance):
            self.recognized.notify_all(candidates, utterance.ended_at, utterance.sender)

    def _may_announce(self, utterance: Utterance) -> bool:
        return bool(self._leave) and self._may_send() and self._admits(utterance.sender, utterance.began_at)

    def forget_speech(self, sender: str) -> None:
        """Drop what this sender said and what was not recognised yet: the consent to it is withdrawn."""
        for utterance in tuple(self._waiting):
            if utterance.sender == sender:
                utterance.withhold()
                if utterance is self._current:
                    utterance.mark_ended(utterance.began_at)
                    self._current = None
                if utterance is not self._tried:
                    self._waiting.remove(utterance)

    def _guess(self, utterance: Utterance, text: str) -> None:
        if self._may_announce(utterance):
            self.guessed.notify_all(text, utterance.sender)

    def _require_consent(self, utterance: Utterance) -> None:
        """Raise `_Withheld` for an utterance of which a part must not be recognised, or must not any more."""
        if not self._admits(utterance.sender, utterance.began_at):
            # A consent that was withdrawn is no failure.
            raise _Withheld
        if not self._may_send():
            utterance.withhold()
        if utterance.withheld:
            raise _Withheld(self.withheld or "an utterance was withheld: not all of it might be sent")

    @contextmanager
    def _spending(self) -> Iterator[None]:
        """Add the time of the block to the figures."""
        began = self._clock.now()
        try:
            yield
        finally:
            self.figures.seconds += self._clock.now() - began

    def _fail(self, reason: str) -> None:
        """Try the failed utterance once more, up to `ATTEMPTS` times; then it is lost."""
        _log.warning("%s", reason)
        self.figures.failed += 1
        if self._tried is not None and self._tried.attempts < ATTEMPTS:
            self._tried = None
            return
        self._done()
        self.failure = reason if self._leave else ""
        self.failed.notify_all(reason)

    def _done(self) -> None:
        """Remove the utterance that was tried from the queue; it may be lost already."""
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
            self._current.mark_ended(self._current.began_at)
            self._current = None
        self._waiting.clear()
        self.failure = ""
        self._changed.set()

    async def _until(self, condition: Callable[[], bool]) -> None:
        while not condition():
            self._changed.clear()
            await self._changed.wait()

    def _begin_utterance(self, at: float) -> None:
        # The sound begins a little before the speech was noticed.
        if not self._admits(self._speech.sender, at - PREROLL):
            return
        if len(self._waiting) == WAITING and self._waiting[0] is not self._tried:
            self.figures.lost = 1 + (self.figures.lost or 0)
        self._current = Utterance(at, self.expected(), self._speech.sender)
        self._waiting.append(self._current)
        self._changed.set()

    def _check_consent(self, at: float) -> None:
        """Forget what was heard until now, where the sound of this moment must not be recognised."""
        if not self._may_send() or not self._admits(self._speech.sender, at):
            self._speech.forget_sound()
            if self._current is not None:
                self._current.withhold()

    def _add_sound(self, samples: NDArray[np.int16]) -> None:
        if self._current is not None:
            self._current.add(samples)

    def _end_utterance(self, at: float) -> None:
        if self._current is not None:
            self._current.mark_ended(at)
            self._current = None
