"""Speech synthesis by espeak-ng in the speech process, which is restarted when it dies or hangs."""

from __future__ import annotations

import asyncio
import importlib.util
import logging
from asyncio.subprocess import Process
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from contextlib import AsyncExitStack, aclosing, asynccontextmanager, suppress
from types import TracebackType
from typing import Any, Final, Self

import numpy as np
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.source.source import SAMPLE_RATE

from openrois.aio.tasks import TaskScope
from openrois_body.processes.child import Output, child_process, write_message
from openrois_body.processes.framing import HEADER, FramingError, decode_body, decode_header, encode
from openrois_body.speech.contract import (
    NamedMark,
    Speech,
    SpeechChunk,
    SpeechRefused,
    SpeechRequest,
    SpeechUnavailable,
    VoiceSettings,
    Word,
    collect_speech,
)
from openrois_body.speech.visemes import Phoneme, VisemeStream

__all__ = ["ANSWER_TIMEOUT", "DEFAULT_RATE", "Synthesizer", "espeak"]

ANSWER_TIMEOUT: Final = 10.0
"""Seconds for a whole answer, with the start of the process; ten minutes of speech take about two."""
_STOP_TIMEOUT: Final = 0.5
"""Seconds for the process to leave a text, which it does within a few milliseconds; then it is ended."""
DEFAULT_RATE: Final = 175
"""Words a minute."""
_CHILD: Final = "openrois_body.speech.espeak_child"
_LIBRARY: Final = "espeakng_loader"
_MISSING: Final = "speech synthesis is not installed: run `pip install 'openrois[speech]'`"

_log = logging.getLogger(__name__)


class Synthesizer:
    """Synthesizes texts, one at a time; others wait their turn. A `SpeechSynthesizer`.

    The process starts with the first request. A process that died between requests is replaced silently; one that dies
    or hangs over a text fails that request, and the next request gets a new process.
    """

    destination = ""
    tells_visemes = True

    def __init__(self, clock: MediaClock | None = None) -> None:
        self._clock = clock or SystemClock()
        self._turn = asyncio.Lock()
        self._running = AsyncExitStack()
        self._output = Output("speech", self._clock)
        self._process: Process | None = None
        self._asked: dict[str, Any] | None = None
        """The request that the process answers now."""
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

    @asynccontextmanager
    async def speak(
        self, request: SpeechRequest, rate: int = DEFAULT_RATE
    ) -> AsyncIterator[AsyncIterator[SpeechChunk]]:
        """Make speech of a text; its pieces come as they are made.

        The process goes on while a piece is waited for by no reader, so that the next text has its turn. Where the
        context is left before the last piece, the process leaves the text and is kept.

        Args:
            request: what is spoken. Elements of SSML other than speak, p, s, voice, prosody, emphasis, break, say-as,
                sub and mark count as their content. The places of words are characters (Unicode code points) of it. Of
                its language the longest available prefix counts, of `de-AT` here `de`.
            rate: words a minute, 80 to 450.
        """
        found, missing = self.available()
        if not found:
            raise SpeechUnavailable(missing)
        asked = {
            "do": "speak",
            "text": request.text,
            "ssml": request.ssml,
            "language": request.language,
            "voice": request.voice,
            "volume": request.volume,
            "rate": rate,
        }
        pieces = _Pieces()
        async with TaskScope() as tasks:
            fetching = tasks.start(self._fetch(asked, pieces))
            try:
                async with aclosing(pieces.chunks()) as chunks:
                    yield chunks
            finally:
                if self._asked is asked:
                    await self._leave(fetching)

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
        """Return the speech of a text when all of it is made; arguments as those of `SpeechRequest` and `speak`.

        Raises:
            SpeechRefused: this text, language or voice cannot be spoken.
            SpeechUnavailable: speech synthesis is not installed, died over this text, or does not answer.
        """
        async with self.speak(SpeechRequest(text, ssml, language, voice, volume), rate) as chunks:
            return await collect_speech(chunks)

    async def _leave(self, fetching: asyncio.Task[None]) -> None:
        """Let the process leave its text, and wait for that."""
        if self._process is not None:
            with suppress(OSError):
                await write_message(self._process, encode({"do": "stop"}))
        await asyncio.wait({fetching}, timeout=_STOP_TIMEOUT)

    async def _fetch(self, request: dict[str, Any], pieces: _Pieces) -> None:
        """Put the pieces of a speech; a failure is raised where they are read."""
        try:
            await self._ask(request, pieces.put)
        except Exception as error:
            pieces.fail(error)

    async def _voices(self) -> dict[str, Any]:
        if self._known is None:
            found, missing = self.available()
            if not found:
                raise SpeechUnavailable(missing)
            answers: list[dict[str, Any]] = []
            await self._ask({"do": "voices"}, lambda answer, _sound: answers.append(answer))
            self._known = answers[0]
        return self._known

    async def _ask(self, request: dict[str, Any], take: Callable[[dict[str, Any], bytes], None]) -> None:
        """Send a request and have its answers taken; a process that dies before the first one is replaced once."""
        taken = 0

        def take_one(answer: dict[str, Any], sound: bytes) -> None:
            nonlocal taken
            taken += 1
            take(answer, sound)

        async with self._turn:
            for _ in range(2):
                try:
                    return await self._exchange(request, take_one)
                except EOFError:
                    _log.info("the speech process has ended and is started again: %s", self._output.last_words)
                if taken:
                    break
        raise SpeechUnavailable(f"the speech process died over this text; try another one: {self._output.last_words}")

    async def _exchange(self, request: dict[str, Any], take: Callable[[dict[str, Any], bytes], None]) -> None:
        """Send a request and have its answers taken; after a failure the process is ended: it may be out of step."""
        try:
            async with asyncio.timeout(ANSWER_TIMEOUT):
                process = await self._start_process()
                self._asked = request
                await write_message(process, encode(request))
                last = False
                while not last:
                    answer, sound = await _read_answer(process)
                    last = answer.get("last", True)
                    take(answer, sound)
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
        finally:
            self._asked = None

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


class _Pieces:
    """The pieces of one speech that were made and not read yet: ten minutes at most, as the process makes no more."""

    def __init__(self) -> None:
        self._lips = VisemeStream()
        self._waiting: deque[SpeechChunk] = deque()
        self._samples = 0
        self._has_ended = False
        self._failure: Exception | None = None
        self._changed = asyncio.Event()

    def put(self, answer: dict[str, Any], sound: bytes) -> None:
        """Add a piece, or take note that there is none, as the process tells it."""
        if "refused" in answer:
            self.fail(SpeechRefused(answer["refused"]))
            return
        samples = np.frombuffer(sound, dtype="<i2")
        self._samples += len(samples)
        visemes = self._lips.add(Phoneme(offset, ipa) for offset, ipa in answer["phonemes"])
        if answer["last"]:
            visemes += self._lips.finish(self._samples * 1000 / SAMPLE_RATE)
            self._has_ended = True
        words = tuple(Word(offset, text, start) for offset, text, start in answer["words"])
        marks = tuple(NamedMark(offset, name) for offset, name in answer["marks"])
        self._waiting.append(SpeechChunk(samples, words, tuple(visemes), marks))
        self._changed.set()

    def fail(self, error: Exception) -> None:
        """End the pieces with an error, at once."""
        self._failure = error
        self._changed.set()

    async def chunks(self) -> AsyncGenerator[SpeechChunk, None]:
        """Yield the pieces until the last one."""
        while True:
            if self._failure is not None:
                raise self._failure
            if self._waiting:
                yield self._waiting.popleft()
            elif self._has_ended:
                return
            else:
                self._changed.clear()
                await self._changed.wait()


async def _read_answer(process: Process) -> tuple[dict[str, Any], bytes]:
    assert process.stdout is not None
    lengths = decode_header(await process.stdout.readexactly(HEADER.size))
    body = await process.stdout.readexactly(lengths.body)
    return decode_body(body), await process.stdout.readexactly(lengths.sound)


def espeak(settings: VoiceSettings) -> Synthesizer:
    """Return the synthesizer of the entry point `espeak`."""
    return Synthesizer(settings.clock)
