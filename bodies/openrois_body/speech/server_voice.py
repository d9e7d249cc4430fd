"""Speech of a server with an API like OpenAI's (`/v1/audio/speech`), played while it arrives."""

from __future__ import annotations

import asyncio
import importlib.util
from collections.abc import AsyncGenerator, AsyncIterator, Iterator
from contextlib import AsyncExitStack, aclosing, asynccontextmanager, contextmanager
from types import TracebackType
from typing import Final, Self

import numpy as np

from openrois.extras import install_command
from openrois_body.services.server import Answer, Server, ServerFailed, ServerRefused
from openrois_body.speech.contract import (
    SpeechChunk,
    SpeechRefused,
    SpeechRequest,
    SpeechUnavailable,
    VoiceSettings,
)
from openrois_body.speech.markup import MAX_SECONDS, MarkupError, spoken_text
from openrois_body.speech.pcm import SoundReader, UnknownSound
from openrois_body.speech.resample import TARGET_RATE

__all__ = ["AT_ONCE", "ServerVoice"]

AT_ONCE: Final = 2
"""Texts that a server or program speaks at a time: what is heard, and what is heard next."""
_RATE: Final = 24_000
"""Hz of raw sound whose media type does not say it: that of OpenAI's."""
_PATH: Final = "audio/speech"
_MODEL: Final = "tts-1"
_VOICE: Final = "alloy"
_ANY_LANGUAGE: Final = "mul"
_KINDS: Final = frozenset(
    {
        *("", "audio/pcm", "audio/x-pcm", "audio/raw", "application/octet-stream"),
        *("audio/wav", "audio/x-wav", "audio/wave", "audio/vnd.wave"),
    }
)
"""Media types of what is asked for, raw samples, and of what is understood as well."""


class ServerVoice:
    """The voice of a server; a `SpeechSynthesizer`. It reads the language from the text, and tells no words.

    Args:
        settings: the server, its model and voices, and its key.
    """

    tells_visemes = False

    def __init__(self, settings: VoiceSettings) -> None:
        self.destination = "" if settings.url is None else settings.url.destination
        self._settings = settings
        self._slots = asyncio.Semaphore(AT_ONCE)
        self._server: Server | None = None
        self._running = AsyncExitStack()

    async def __aenter__(self) -> Self:
        if self._settings.url is not None and self.available()[0]:
            server = Server(self._settings.url, "the speech server", "--voice-url", self._settings.key_file)
            self._server = await self._running.enter_async_context(server)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._running.aclose()

    def available(self) -> tuple[bool, str]:
        """Return whether a server was named; whether that is there is seen when it speaks."""
        if self._settings.url is None:
            return False, "the voice of a server needs its address: --voice-url https://example.org/v1"
        if importlib.util.find_spec("aiohttp") is None:
            return False, f"aiohttp is not installed: run `{install_command('speech')}`"
        return True, ""

    async def languages(self) -> tuple[str, ...]:
        """Return `mul`: the server reads the language from the text."""
        return (_ANY_LANGUAGE,)

    async def voices(self) -> tuple[str, ...]:
        """Return the voices that were named."""
        return self._settings.names

    @asynccontextmanager
    async def speak(self, request: SpeechRequest) -> AsyncIterator[AsyncIterator[SpeechChunk]]:
        """Have a text spoken; its pieces come as they arrive. SSML is spoken as its text."""
        if self._server is None:
            raise SpeechUnavailable(self.available()[1] or "the voice is not entered")
        asked = {
            "model": self._settings.model or _MODEL,
            "voice": self._voice(request.voice),
            "input": _text(request),
            "response_format": "pcm",
        }
        async with AsyncExitStack() as stack:
            if not asked["input"]:
                yield await stack.enter_async_context(aclosing(_silence()))
                return
            await stack.enter_async_context(self._slots)
            with _translated():
                answer = await stack.enter_async_context(self._server.post(_PATH, asked))
                reader = _reader(answer, request.volume)
            yield await stack.enter_async_context(aclosing(_chunks(answer, reader)))

    def _voice(self, voice: str | None) -> str:
        names = self._settings.names or (_VOICE,)
        if voice is not None and voice not in names:
            raise SpeechRefused(f"the voice {voice!r} is not available; available_voices lists the voices")
        return voice or names[0]


def _text(request: SpeechRequest) -> str:
    try:
        return spoken_text(request.text, ssml=request.ssml)
    except MarkupError as error:
        raise SpeechRefused(str(error)) from error


def _reader(answer: Answer, volume: int) -> SoundReader:
    if answer.kind not in _KINDS:
        raise ServerFailed(f"the speech server answers with {answer.kind[:80]} where samples (pcm) were asked for")
    told = answer.parameters.get("rate", "")
    return SoundReader(int(told) if told.isascii() and told.isdigit() and len(told) < 8 else _RATE, volume)


async def _chunks(answer: Answer, reader: SoundReader) -> AsyncGenerator[SpeechChunk, None]:
    # Two channels of 48 kHz are the most that is understood.
    most = MAX_SECONDS * TARGET_RATE * 4
    left = MAX_SECONDS * TARGET_RATE
    with _translated():
        async for part in answer.parts(most, MAX_SECONDS):
            samples = reader.add(part)
            left -= len(samples)
            if left < 0:
                raise ServerRefused(f"the speech is longer than {MAX_SECONDS} seconds; split the text")
            if len(samples):
                yield SpeechChunk(samples)
        yield SpeechChunk(reader.finish())


async def _silence() -> AsyncGenerator[SpeechChunk, None]:
    """Yield no sound: there is nothing to speak in a text."""
    yield SpeechChunk(np.zeros(0, np.int16))


@contextmanager
def _translated() -> Iterator[None]:
    try:
        yield
    except ServerRefused as error:
        raise SpeechRefused(str(error)) from error
    except (ServerFailed, UnknownSound) as error:
        raise SpeechUnavailable(str(error)) from error
