"""What holds for every synthesizer: ours, and the one that the guide shows."""

import re
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openrois_body.speech.contract import (
    Speech,
    SpeechChunk,
    SpeechRefused,
    SpeechRequest,
    SpeechSynthesizer,
    VoiceSettings,
    collect_speech,
)
from openrois_body.speech.piper import Piper
from openrois_body.speech.server_voice import ServerVoice
from openrois_body.speech.synthesizer import Synthesizer

from tests.body.speech.test_piper import describe, fake_piper
from tests.support.packages import ROOT
from tests.support.speech_server import speech_server

pytestmark = pytest.mark.engine

SENTENCE = "Good morning, and welcome to you all."


async def whole(synthesizer: SpeechSynthesizer, request: SpeechRequest) -> Speech:
    async with synthesizer.speak(request) as chunks:
        return await collect_speech(chunks)


class SynthesizerContract(ABC):
    """The rules, tried on a synthesizer that `made` makes."""

    @abstractmethod
    def made(self, folder: Path) -> AbstractAsyncContextManager[SpeechSynthesizer]:
        """Make a synthesizer that works."""

    @pytest.fixture
    async def synthesizer(self, tmp_path: Path) -> AsyncIterator[SpeechSynthesizer]:
        async with self.made(tmp_path) as synthesizer, synthesizer:
            yield synthesizer

    async def test_it_works_and_has_a_language(self, synthesizer: SpeechSynthesizer) -> None:
        assert synthesizer.available() == (True, "")
        assert await synthesizer.languages()
        assert isinstance(await synthesizer.voices(), Sequence)
        assert synthesizer.destination == ""

    async def test_a_text_is_sound_in_pieces(self, synthesizer: SpeechSynthesizer) -> None:
        async with synthesizer.speak(SpeechRequest(SENTENCE)) as chunks:
            pieces = [chunk async for chunk in chunks]
        samples = np.concatenate([piece.samples for piece in pieces])
        assert samples.dtype == np.int16
        assert samples.ndim == 1
        assert 0.5 < len(samples) / 48_000 < 10
        assert np.abs(samples).max() > 1000
        self.require_order(pieces, synthesizer.tells_visemes)

    def require_order(self, pieces: Sequence[SpeechChunk], tells_visemes: bool) -> None:
        before = 0.0
        for piece in pieces:
            told = [word.offset_ms for word in piece.words] + [mark.offset_ms for mark in piece.marks]
            told += [viseme.offset_ms for viseme in piece.visemes]
            assert all(offset_ms >= before - 10 for offset_ms in told), "what is told comes with its sound, or before"
            before += len(piece.samples) / 48
        shapes = [viseme.shape for piece in pieces for viseme in piece.visemes]
        assert bool(shapes) is tells_visemes
        assert shapes[-1:] in ([], ["sil"])

    async def test_volume_is_heeded(self, synthesizer: SpeechSynthesizer) -> None:
        assert not (await whole(synthesizer, SpeechRequest(SENTENCE, volume=0))).samples.any()
        loud = (await whole(synthesizer, SpeechRequest(SENTENCE, volume=100))).samples
        quiet = (await whole(synthesizer, SpeechRequest(SENTENCE, volume=20))).samples
        assert np.abs(quiet).max() == pytest.approx(np.abs(loud).max() / 5, rel=0.2)

    async def test_ssml_is_spoken(self, synthesizer: SpeechSynthesizer) -> None:
        request = SpeechRequest("<speak>Good <emphasis>morning</emphasis> &amp; welcome.</speak>", ssml=True)
        assert (await whole(synthesizer, request)).duration > 0.3

    async def test_an_unknown_voice_is_refused(self, synthesizer: SpeechSynthesizer) -> None:
        with pytest.raises(SpeechRefused):
            await whole(synthesizer, SpeechRequest(SENTENCE, voice="no such voice"))

    async def test_a_speech_may_be_left_and_another_one_follows(self, synthesizer: SpeechSynthesizer) -> None:
        async with synthesizer.speak(SpeechRequest(SENTENCE * 5)) as chunks:
            await anext(chunks)
        assert (await whole(synthesizer, SpeechRequest(SENTENCE))).duration > 0.5


class TestEspeak(SynthesizerContract):
    """espeak-ng in its process."""

    @asynccontextmanager
    async def made(self, folder: Path) -> AsyncIterator[SpeechSynthesizer]:
        yield Synthesizer()


class TestServer(SynthesizerContract):
    """A server that speaks with espeak-ng."""

    @asynccontextmanager
    async def made(self, folder: Path) -> AsyncIterator[SpeechSynthesizer]:
        async with speech_server() as server:
            yield ServerVoice(VoiceSettings(server.address))


class TestPiper(SynthesizerContract):
    """A program with the command line of Piper that speaks with espeak-ng."""

    @asynccontextmanager
    async def made(self, folder: Path) -> AsyncIterator[SpeechSynthesizer]:
        with pytest.MonkeyPatch.context() as environment:
            fake_piper(folder, environment)
            (folder / "v.onnx").touch()
            describe(folder / "v.onnx")
            yield Piper(VoiceSettings(file=folder / "v.onnx"))


class TestOfTheGuide(SynthesizerContract):
    """The one that docs/how-to/voices-and-ears.md shows."""

    @asynccontextmanager
    async def made(self, folder: Path) -> AsyncIterator[SpeechSynthesizer]:
        page = (ROOT / "docs/how-to/voices-and-ears.md").read_text(encoding="utf-8")
        (source,) = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
        found: dict[str, Any] = {}
        exec(source, found)
        yield found["Hum"](VoiceSettings())
