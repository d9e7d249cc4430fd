"""Speech of the program `piper`, with a voice file that the user has; a process for each text.

Piper is GPL-3.0 (its older versions link espeak-ng, which is): it is a program that the user installs, run as a process
of its own, and no part of it is imported or shipped here.
"""

from __future__ import annotations

import asyncio
import json
import shutil
from asyncio.subprocess import Process
from collections.abc import AsyncGenerator, AsyncIterator
from contextlib import aclosing, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Final, Self

from openrois_streaming.clock import SystemClock

from openrois_body.processes.child import Output, child_process, write_message
from openrois_body.services.server import BEGIN_TIMEOUT, STALL_TIMEOUT
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
from openrois_body.speech.server_voice import AT_ONCE

__all__ = ["MAX_CONFIG", "Piper"]

MAX_CONFIG: Final = 1 << 20
"""Bytes of the file that describes a voice."""
_PROGRAM: Final = "piper"
_LAUNCHER: Final = "openrois_body.processes.program"
_PART: Final = 16_384
_DESCRIPTION: Final = ".json"


@dataclass(frozen=True, slots=True)
class _Description:
    """What the file beside a voice says of it: Hz, language, and the numbers of its speakers by their names."""

    rate: int
    language: str
    speakers: dict[str, int]


class Piper:
    """A voice of Piper; a `SpeechSynthesizer`. It tells no words; its sound comes sentence by sentence.

    Args:
        settings: the voice's file, and the speakers to choose from where it has several.
    """

    destination = ""
    tells_visemes = False

    def __init__(self, settings: VoiceSettings) -> None:
        self._file = settings.file
        self._names = settings.names
        self._slots = asyncio.Semaphore(AT_ONCE)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Nothing is left: each speech ends its own process."""

    def available(self) -> tuple[bool, str]:
        """Return whether the program and the voice are there; if not, the sentence that says what to do."""
        try:
            self._described()
        except SpeechUnavailable as error:
            return False, str(error)
        if shutil.which(_PROGRAM) is None:
            return (
                False,
                "the program piper is not installed: run `pipx install piper-tts` (GPL-3.0), or add it to PATH",
            )
        return True, ""

    async def languages(self) -> tuple[str, ...]:
        """Return the language of the voice."""
        return (self._described()[1].language,)

    async def voices(self) -> tuple[str, ...]:
        """Return the speakers to choose from."""
        return self._names or tuple(self._described()[1].speakers)

    @asynccontextmanager
    async def speak(self, request: SpeechRequest) -> AsyncIterator[AsyncIterator[SpeechChunk]]:
        """Have a text spoken; its pieces come as they are made. SSML is spoken as its text."""
        works, reason = self.available()
        program = shutil.which(_PROGRAM)
        if not works or program is None:
            raise SpeechUnavailable(reason)
        file, described = self._described()
        try:
            text = spoken_text(request.text, ssml=request.ssml)
            reader = SoundReader(described.rate, request.volume)
        except MarkupError as error:
            raise SpeechRefused(str(error)) from error
        except UnknownSound as error:
            raise SpeechUnavailable(str(error)) from error
        arguments = (program, "--model", str(file), "--output_raw", *self._speaker(request.voice, described))
        output = Output(_PROGRAM, SystemClock())
        async with (
            self._slots,
            child_process(_LAUNCHER, *arguments, output=output, conversation=True) as process,
            aclosing(_chunks(process, output, text, reader)) as chunks,
        ):
            yield chunks

    def _described(self) -> tuple[Path, _Description]:
        if self._file is None:
            raise SpeechUnavailable("a voice of Piper needs its file: --voice-file VOICE.onnx")
        if not self._file.is_file():
            raise SpeechUnavailable(f"--voice-file: there is no file {self._file}")
        path = self._file.with_name(self._file.name + _DESCRIPTION)
        try:
            with path.open("rb") as file:
                told = json.loads(file.read(MAX_CONFIG))
            return self._file, _read(told)
        except OSError as error:
            raise SpeechUnavailable(f"--voice-file: {path}, which has to be beside it: {error.strerror}") from None
        except (ValueError, KeyError, TypeError, AttributeError):
            raise SpeechUnavailable(f"--voice-file: {path} is no description of a voice of Piper") from None

    def _speaker(self, voice: str | None, described: _Description) -> tuple[str, ...]:
        """Return the options that choose a speaker; by default the first one that was named."""
        name = voice or (self._names[0] if self._names else None)
        if name is None:
            return ()
        if name not in described.speakers:
            raise SpeechRefused(f"the voice {name!r} is not available; available_voices lists the voices")
        return ("--speaker", str(described.speakers[name]))


def _read(told: Any) -> _Description:
    language = told.get("language", {}).get("code") or told.get("espeak", {}).get("voice") or "und"
    speakers = {str(name): int(number) for name, number in told.get("speaker_id_map", {}).items()}
    return _Description(int(told["audio"]["sample_rate"]), str(language).lower().replace("_", "-"), speakers)


async def _chunks(
    process: Process, output: Output, text: str, reader: SoundReader
) -> AsyncGenerator[SpeechChunk, None]:
    left = MAX_SECONDS * TARGET_RATE
    patience = BEGIN_TIMEOUT
    try:
        await write_message(process, f"{text}\n".encode())
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.close()
        while part := await _within(patience, process.stdout.read(_PART)):
            patience = STALL_TIMEOUT
            samples = reader.add(part)
            left -= len(samples)
            if left < 0:
                raise SpeechRefused(f"the speech is longer than {MAX_SECONDS} seconds; split the text")
            yield SpeechChunk(samples)
        status = await _within(STALL_TIMEOUT, process.wait())
    except OSError:
        status = await _within(STALL_TIMEOUT, process.wait())
    if status != 0:
        await output.all_said()
        raise SpeechUnavailable(f"piper ended with status {status}: {output.last_words}".rstrip(" :"))
    yield SpeechChunk(reader.finish())


async def _within(seconds: float, work: Any) -> Any:
    try:
        async with asyncio.timeout(seconds):
            return await work
    except TimeoutError:
        raise SpeechUnavailable(f"piper gave nothing for {seconds:g} s, and was ended") from None
