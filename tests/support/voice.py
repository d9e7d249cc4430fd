"""A voice without a speech process: texts become silence of a known length."""

import asyncio
import re
from collections.abc import AsyncGenerator, AsyncIterator, Sequence
from contextlib import aclosing, asynccontextmanager
from types import TracebackType
from typing import Self

import numpy as np
from openrois_body.messages import Viseme
from openrois_body.speech.contract import (
    NamedMark,
    SpeechChunk,
    SpeechRefused,
    SpeechRequest,
    SpeechUnavailable,
    Word,
)


class ScriptedSynthesizer:
    """Speaks every text in `seconds`, and remembers how it was asked; can be missing or refuse.

    Each of its words takes as long as the others; one in `<>` is a mark.
    """

    destination = ""
    tells_visemes = True

    def __init__(self, seconds: float = 1.0) -> None:
        self.seconds = seconds
        self.asked: list[tuple[str, str, str | None, int, bool]] = []
        self.installed = True
        self.refuses = False
        self.ready = asyncio.Event()
        self.ready.set()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass

    def available(self) -> tuple[bool, str]:
        return self.installed, "" if self.installed else "install it"

    async def languages(self) -> Sequence[str]:
        self._require()
        return ("en", "de")

    async def voices(self) -> Sequence[str]:
        self._require()
        return ("f1", "m1")

    @asynccontextmanager
    async def speak(self, request: SpeechRequest) -> AsyncIterator[AsyncIterator[SpeechChunk]]:
        async with aclosing(self._chunks(request)) as chunks:
            yield chunks

    async def _chunks(self, request: SpeechRequest) -> AsyncGenerator[SpeechChunk, None]:
        self._require()
        await self.ready.wait()
        if self.refuses:
            raise SpeechRefused("not available")
        text = request.text
        self.asked.append((text, request.language, request.voice, request.volume, request.ssml))
        samples = np.full(round(self.seconds * 48_000), 1000, dtype=np.int16)
        found = list(re.finditer(r"\S+", text))
        share = self.seconds * 1000 / max(1, len(found))
        moments = [(number * share, match[0], match.start()) for number, match in enumerate(found)]
        yield SpeechChunk(
            samples,
            tuple(Word(*moment) for moment in moments if "<" not in moment[1]),
            (Viseme(0.0, "aa", 1.0), Viseme(self.seconds * 1000, "sil", 0.0)),
            tuple(NamedMark(offset, text.strip("<>")) for offset, text, _ in moments if "<" in text),
        )

    def _require(self) -> None:
        if not self.installed:
            raise SpeechUnavailable("install it")
