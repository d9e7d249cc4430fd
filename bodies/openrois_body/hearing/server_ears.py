"""Speech recognition by a server with an API like OpenAI's (`/v1/audio/transcriptions`), one utterance a request."""

from __future__ import annotations

import importlib.util
import json
import re
import wave
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from io import BytesIO
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.downsample import SPEECH_RATE

from openrois.extras import install_command
from openrois_body.hearing.jsgf import Grammar, GrammarError, chosen_grammar
from openrois_body.hearing.recognizer import OTHER_SPEECH, EarsSettings, Expectation, RecognizerFailed, Transcriber
from openrois_body.services.events import EventReader, MalformedEvents
from openrois_body.services.server import BEGIN_TIMEOUT, Answer, Server, ServerFailed, ServerRefused

__all__ = ["MAX_UTTERANCE", "ServerEars"]

MAX_UTTERANCE: Final = 120
"""Seconds of an utterance that are sent; what follows is lost."""
_PATH: Final = "audio/transcriptions"
_MODEL: Final = "whisper-1"
_MAX_ANSWER: Final = 1 << 20
_MAX_WORDS: Final = 8_000
"""Characters of what is recognised that are told."""
_LANGUAGES: Final = (
    *("en", "af", "ar", "az", "be", "bg", "bs", "ca", "cs", "cy", "da", "de", "el", "es", "et", "fa", "fi", "fr", "gl"),
    *("he", "hi", "hr", "hu", "hy", "id", "is", "it", "ja", "kk", "kn", "ko", "lt", "lv", "mi", "mk", "mr", "ms", "ne"),
    *("nl", "no", "pl", "pt", "ro", "ru", "sk", "sl", "sr", "sv", "sw", "ta", "th", "tl", "tr", "uk", "ur", "vi", "zh"),
)
"""Those that the models of this API are made for."""
_APART: Final = re.compile(r"[^\w'’]+")  # noqa: RUF001 - both are written


class ServerEars:
    """Recognition by a server; a `SpeechRecognizer`.

    Args:
        settings: the server, its model, and its key.
    """

    languages = _LANGUAGES

    def __init__(self, settings: EarsSettings) -> None:
        self.destination = "" if settings.url is None else settings.url.destination
        self._settings = settings
        self._streams = True
        """Whether the server has not refused to be asked for partial results."""

    def available(self) -> tuple[bool, str]:
        """Return whether a server was named; whether that is there is seen when it is asked."""
        if self._settings.url is None:
            return False, "recognition by a server needs its address: --ears-url https://example.org/v1"
        if importlib.util.find_spec("aiohttp") is None:
            return False, f"aiohttp is not installed: run `{install_command('hearing')}`"
        return True, ""

    def refusal(self, expected: Expectation) -> str:
        """Return why this cannot be expected."""
        try:
            chosen_grammar(expected.grammar, expected.rule)
        except GrammarError as error:
            return str(error)
        return ""

    @asynccontextmanager
    async def open(self) -> AsyncIterator[Transcriber]:
        """Ask whether the server is there, and keep connections to it for as long as the context lasts."""
        works, reason = self.available()
        if self._settings.url is None or not works:
            raise RecognizerFailed(reason)
        server = Server(self._settings.url, "the recognition server", "--ears-url", self._settings.key_file)
        try:
            async with server:
                await server.probe()
                yield _Transcriber(self, server, self._settings.model or _MODEL)
        except ServerFailed as error:
            raise RecognizerFailed(str(error)) from error

    async def transcribe(
        self, server: Server, fields: dict[str, str], sound: bytes, guess: Callable[[str], None]
    ) -> str:
        """Return what a server understands of a WAV file; with partial results where it has them."""
        if self._streams:
            try:
                return await _transcribed(server, {**fields, "stream": "true"}, sound, guess)
            except ServerRefused:
                # It may refuse the field, or the sound: the latter, and only that, it does again.
                text = await _transcribed(server, fields, sound, guess)
                self._streams = False
                return text
        return await _transcribed(server, fields, sound, guess)


class _Transcriber:
    """Collects an utterance, and sends it when it has ended."""

    def __init__(self, ears: ServerEars, server: Server, model: str) -> None:
        self._ears = ears
        self._server = server
        self._model = model
        self._grammar: Grammar | None = None
        self._rule = ""
        self._fields: dict[str, str] = {}
        self._parts: list[NDArray[np.int16]] = []
        self._left = 0

    async def begin(self, expected: Expectation) -> None:
        self._grammar, self._rule = chosen_grammar(expected.grammar, expected.rule)
        language = {"language": expected.languages[0]} if len(expected.languages) == 1 else {}
        self._fields = {"model": self._model, "response_format": "json", **language}
        self._parts, self._left = [], MAX_UTTERANCE * SPEECH_RATE

    async def hear(self, samples: NDArray[np.int16]) -> str:
        self._parts.append(samples[: self._left])
        self._left -= len(self._parts[-1])
        return ""

    async def finish(self, guess: Callable[[str], None]) -> tuple[str, ...]:
        parts, self._parts = self._parts, []
        try:
            text = await self._ears.transcribe(self._server, self._fields, _wave_file(parts), guess)
        except ServerFailed as error:
            raise RecognizerFailed(str(error)) from error
        text = " ".join(text.split())[:_MAX_WORDS]
        if self._grammar is not None:
            # The rules of a grammar have small letters and no punctuation.
            text = " ".join(_APART.sub(" ", text.lower()).split())
            if text and not self._grammar.accepts(self._rule, text):
                return (OTHER_SPEECH,) if self._grammar.has_other_speech(self._rule) else ()
        return (text,) if text else ()


async def _transcribed(server: Server, fields: dict[str, str], sound: bytes, guess: Callable[[str], None]) -> str:
    async with server.post_sound(_PATH, fields, sound) as answer:
        if answer.kind == "text/event-stream":
            return await _streamed(server, answer, guess)
        if answer.kind != "application/json":
            raise ServerFailed(
                f"{server.name} answers with {answer.kind[:80] or 'nothing known'} where JSON was asked for"
            )
        told = _object(server, await answer.text(_MAX_ANSWER))
    if not isinstance(text := told.get("text"), str):
        raise ServerFailed(f"{server.name} answers without a text")
    return text


async def _streamed(server: Server, answer: Answer, guess: Callable[[str], None]) -> str:
    """Return the text that the last event has; those before have the next part of it."""
    reader, so_far = EventReader(), ""
    try:
        async for part in answer.parts(_MAX_ANSWER, BEGIN_TIMEOUT):
            for event in reader.add(part):
                told = {} if event == "[DONE]" else _object(server, event)
                if told.get("type") == "transcript.text.done" and isinstance(told.get("text"), str):
                    return str(told["text"])
                if told.get("type") == "transcript.text.delta" and isinstance(told.get("delta"), str):
                    so_far = (so_far + told["delta"])[:_MAX_WORDS]
                    guess(so_far)
                if "error" in told:
                    raise ServerFailed(f"{server.name} has failed in the middle of its answer")
    except MalformedEvents as error:
        raise ServerFailed(f"{server.name} answers with no events that can be read: {error}") from None
    raise ServerFailed(f"{server.name} ended its answer before the text was complete")


def _object(server: Server, text: str) -> dict[str, Any]:
    try:
        told = json.loads(text)
    except (ValueError, RecursionError):
        told = None
    if not isinstance(told, dict):
        raise ServerFailed(f"{server.name} answers with no JSON object")
    return told


def _wave_file(parts: list[NDArray[np.int16]]) -> bytes:
    file = BytesIO()
    with wave.open(file, "wb") as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(SPEECH_RATE)
        for part in parts:
            sound.writeframes(part.astype("<i2").tobytes())
    return file.getvalue()
