"""Speech synthesis by the speech process, which is restarted when it dies or hangs."""

from __future__ import annotations

import asyncio
import importlib.util
import logging
from asyncio.subprocess import Process
from collections.abc import Iterator
from contextlib import AsyncExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.source.source import SAMPLE_RATE

from openrois_body.messages import MAX_VISEMES, Speak, Viseme
from openrois_body.processes.child import Output, child_process, write_message
from openrois_body.processes.framing import HEADER, FramingError, decode_body, decode_header, encode
from openrois_body.sound.engine_sound import SEAM
from openrois_body.speech.visemes import Phoneme, visemes

ANSWER_TIMEOUT: Final = 10.0
"""Seconds for an answer, with the start of the process; ten minutes of speech take about two."""
DEFAULT_RATE: Final = 175
"""Words a minute."""
_CHILD: Final = "openrois_body.speech.espeak_child"
_LIBRARY: Final = "espeakng_loader"
_MISSING: Final = "speech synthesis is not installed: run `pip install 'openrois[speech]'`"

_log = logging.getLogger(__name__)


class SpeechUnavailable(Exception):
    """Speech synthesis is not available now; the text says why, and what to install if something is missing."""


class SpeechRefused(ValueError):
    """A refused text: an unknown language or voice, malformed SSML, too long; the text says which."""


class Word(NamedTuple):
    """A word: when it begins, its text, and the position of its first character in the whole text."""

    offset_ms: float
    text: str
    position: int


class NamedMark(NamedTuple):
    """A mark of SSML, and when it is reached."""

    offset_ms: float
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Speech:
    """A text as sound and mouth shapes.

    `samples` is mono at 48 kHz; all else is in order of time, and `visemes` end with the mouth closed.
    """

    samples: NDArray[np.int16]
    words: tuple[Word, ...]
    visemes: tuple[Viseme, ...]
    marks: tuple[NamedMark, ...] = ()

    @property
    def duration(self) -> float:
        """Seconds."""
        return len(self.samples) / SAMPLE_RATE

    @property
    def moments(self) -> tuple[Word | NamedMark, ...]:
        """The words and marks in order of time."""
        return tuple(sorted((*self.marks, *self.words), key=lambda moment: moment.offset_ms))

    def after(self, samples: int) -> Speech:
        """Return the rest after so many samples; it fades in within 5 ms."""
        gone = samples * 1000 / SAMPLE_RATE
        left = self.samples[samples:].copy()
        seam = min(SEAM, len(left))
        left[:seam] = left[:seam] * (np.arange(seam) + 0.5) / SEAM
        shape = [viseme for viseme in self.visemes if viseme.offset_ms <= gone][-1:]
        return Speech(
            left,
            tuple(word._replace(offset_ms=word.offset_ms - gone) for word in self.words if word.offset_ms >= gone),
            (
                *(Viseme(0.0, viseme.shape, viseme.weight) for viseme in shape),
                *(
                    Viseme(viseme.offset_ms - gone, viseme.shape, viseme.weight)
                    for viseme in self.visemes
                    if viseme.offset_ms > gone
                ),
            ),
            tuple(mark._replace(offset_ms=mark.offset_ms - gone) for mark in self.marks if mark.offset_ms >= gone),
        )

    def mouth(self, speech_id: str, start_ns: int) -> Iterator[Speak]:
        """Return the commands for an engine's mouth, for a speech that starts at `start_ns` of CLOCK_MONOTONIC.

        One, or for a very long speech several, each for the part of it that begins at its `start_ns`.
        """
        end = self.duration * 1000
        for first in range(0, len(self.visemes), MAX_VISEMES):
            part = self.visemes[first : first + MAX_VISEMES]
            after = self.visemes[first + MAX_VISEMES :]
            begin = part[0].offset_ms if first else 0.0
            until = after[0].offset_ms if after else end
            moved = tuple(Viseme(viseme.offset_ms - begin, viseme.shape, viseme.weight) for viseme in part)
            yield Speak(speech_id, start_ns + round(begin * 1e6), moved, round(until - begin))


class Synthesizer:
    """Synthesizes texts, one at a time; others wait their turn. Leaving the context ends the process.

    The process starts with the first request. A process that died between requests is replaced silently; one that dies
    or hangs over a text fails that request, and the next request gets a new process.
    """

    def __init__(self, clock: MediaClock | None = None) -> None:
        self._clock = clock or SystemClock()
        self._turn = asyncio.Lock()
        self._running = AsyncExitStack()
        self._output = Output("speech", self._clock)
        self._process: Process | None = None
        self._known: dict[str, Any] | None = None

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._end_process()

    def available(self) -> tuple[bool, str]:
        """Return whether speech synthesis is installed; if not, the sentence that says what to do."""
        found = importlib.util.find_spec(_LIBRARY) is not None
        return found, "" if found else _MISSING

    async def languages(self) -> tuple[str, ...]:
        """Return the available languages, as BCP 47 tags in lower case.

        Raises:
            SpeechUnavailable: the speech process does not run or answer.
        """
        return tuple((await self._voices())["languages"])

    async def voices(self) -> tuple[str, ...]:
        """Return the available voices; each speaks every language.

        Raises:
            SpeechUnavailable: the speech process does not run or answer.
        """
        return tuple((await self._voices())["voices"])

    async def synthesize(
        self,
        text: str,
        *,
        language: str = "en",
        voice: str | None = None,
        volume: int = 50,
        rate: int = DEFAULT_RATE,
        ssml: bool = False,
    ) -> Speech:
        """Make speech of a text.

        Args:
            text: at most 4,000 characters; an SSML document or a fragment of one if `ssml`. Elements other than speak,
                p, s, voice, prosody, emphasis, break, say-as, sub and mark count as their content. The places of words
                are characters (Unicode code points) of it.
            language: a BCP 47 tag; the longest available prefix counts, of `de-AT` here `de`.
            voice: one of `voices()`; None for the language's own.
            volume: 0 (silent) to 100 (the loudest without distortion).
            rate: words a minute, 80 to 450.
            ssml: whether `text` is SSML.

        Raises:
            SpeechRefused: this text, language or voice cannot be spoken.
            SpeechUnavailable: speech synthesis is not installed, died over this text, or does not answer.
        """
        request = {"do": "speak", "text": text, "ssml": ssml, "language": language, "voice": voice}
        answer, sound = await self._ask({**request, "volume": volume, "rate": rate})
        if "refused" in answer:
            raise SpeechRefused(answer["refused"])
        return _speech(answer, sound)

    async def _voices(self) -> dict[str, Any]:
        if self._known is None:
            self._known, _ = await self._ask({"do": "voices"})
        return self._known

    async def _ask(self, request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
        found, missing = self.available()
        if not found:
            raise SpeechUnavailable(missing)
        async with self._turn:
            for _ in range(2):
                try:
                    return await self._exchange(request)
                except EOFError:
                    _log.info("the speech process has ended and is started again: %s", self._output.last_words)
        raise SpeechUnavailable(f"the speech process died over this text; try another one: {self._output.last_words}")

    async def _exchange(self, request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
        """Send a request and return its answer; after a failure the process is ended, as it may be out of step."""
        try:
            async with asyncio.timeout(ANSWER_TIMEOUT):
                return await _converse(await self._start_process(), request)
        except TimeoutError as error:
            await self._end_process()
            raise SpeechUnavailable(
                f"the speech process did not answer within {ANSWER_TIMEOUT:g} seconds; try a shorter text"
            ) from error
        except (OSError, FramingError) as error:
            await self._end_process()
            raise EOFError from error
        except BaseException:
            await self._end_process()
            raise

    async def _start_process(self) -> Process:
        if self._process is None:
            self._output = Output("speech", self._clock)
            # The one product of matrices there is not worth threads that wait for each other.
            environment = {"OPENBLAS_NUM_THREADS": "1"}
            running = child_process(_CHILD, output=self._output, environment=environment, conversation=True)
            self._process = await self._running.enter_async_context(running)
        return self._process

    async def _end_process(self) -> None:
        running, self._running, self._process = self._running, AsyncExitStack(), None
        await running.aclose()


async def _converse(process: Process, request: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    assert process.stdout is not None
    await write_message(process, encode(request))
    lengths = decode_header(await process.stdout.readexactly(HEADER.size))
    body = await process.stdout.readexactly(lengths.body)
    return decode_body(body), await process.stdout.readexactly(lengths.sound)


def _speech(answer: dict[str, Any], sound: bytes) -> Speech:
    samples = np.frombuffer(sound, dtype="<i2")
    text = answer["text"]
    words = tuple(Word(offset, text[start : start + length], start) for offset, start, length in answer["words"])
    phonemes = (Phoneme(offset, ipa) for offset, ipa in answer["phonemes"])
    marks = tuple(NamedMark(offset, name) for offset, name in answer["marks"])
    return Speech(samples, words, visemes(phonemes, len(samples) * 1000 / SAMPLE_RATE), marks)
