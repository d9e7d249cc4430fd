"""A voice without a speech process: texts become silence of a known length."""

from collections.abc import Sequence

import numpy as np
from openrois_avatar.link.messages import Viseme
from openrois_avatar.speech.synthesizer import Speech, SpeechRefused, SpeechUnavailable


class ScriptedSynthesizer:
    """Speaks every text in `seconds`, and remembers how it was asked; can be missing or refuse."""

    def __init__(self, seconds: float = 1.0) -> None:
        self.seconds = seconds
        self.asked: list[tuple[str, str, str | None, int, bool]] = []
        self.installed = True
        self.refuses = False

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
        if self.refuses:
            raise SpeechRefused("nobody speaks that")
        self.asked.append((text, language, voice, volume, ssml))
        samples = np.full(round(self.seconds * 48_000), 1000, dtype=np.int16)
        return Speech(samples, (), (Viseme(0.0, "aa", 1.0), Viseme(self.seconds * 1000, "sil", 0.0)))

    def _require(self) -> None:
        if not self.installed:
            raise SpeechUnavailable("install it")
