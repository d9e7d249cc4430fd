"""A voice without a speech process: texts become silence of a known length."""

import asyncio
import re
from collections.abc import Sequence

import numpy as np
from openrois_body.messages import Viseme
from openrois_body.speech.synthesizer import NamedMark, Speech, SpeechRefused, SpeechUnavailable, Word


class ScriptedSynthesizer:
    """Speaks every text in `seconds`, and remembers how it was asked; can be missing or refuse.

    Each of its words takes as long as the others; one in `<>` is a mark.
    """

    def __init__(self, seconds: float = 1.0) -> None:
        self.seconds = seconds
        self.asked: list[tuple[str, str, str | None, int, bool]] = []
        self.installed = True
        self.refuses = False
        self.ready = asyncio.Event()
        self.ready.set()

    def available(self) -> tuple[bool, str]:
        return self.installed, "" if self.installed else "install it"

    async def languages(self) -> Sequence[str]:
        self._require()
        return ("en", "de")

    async def voices(self) -> Sequence[str]:
        self._require()
        return ("f1", "m1")

    async def synthesize(
        self, text: str, *, language: str = "en", voice: str | None = None, volume: int = 50, ssml: bool = False
    ) -> Speech:
        self._require()
        await self.ready.wait()
        if self.refuses:
            raise SpeechRefused("not available")
        self.asked.append((text, language, voice, volume, ssml))
        samples = np.full(round(self.seconds * 48_000), 1000, dtype=np.int16)
        found = list(re.finditer(r"\S+", text))
        share = self.seconds * 1000 / max(1, len(found))
        moments = [(number * share, match[0], match.start()) for number, match in enumerate(found)]
        return Speech(
            samples,
            tuple(Word(*moment) for moment in moments if "<" not in moment[1]),
            (Viseme(0.0, "aa", 1.0), Viseme(self.seconds * 1000, "sil", 0.0)),
            tuple(NamedMark(offset, text.strip("<>")) for offset, text, _ in moments if "<" in text),
        )

    def _require(self) -> None:
        if not self.installed:
            raise SpeechUnavailable("install it")
