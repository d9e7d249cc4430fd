"""Speech of Piper as a process: of the real program where it and a voice are there, else of one with its command line.

A voice is taken from the file that PIPER_VOICE names; none is downloaded.
"""

import asyncio
import json
import os
import shutil
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import numpy as np
import psutil
import pytest
from openrois_body.speech import piper as module
from openrois_body.speech.contract import (
    SpeechRefused,
    SpeechRequest,
    SpeechUnavailable,
    VoiceSettings,
    collect_speech,
)
from openrois_body.speech.piper import Piper

from tests.support.packages import ROOT

pytestmark = pytest.mark.engine

DESCRIPTION = {
    "audio": {"sample_rate": 24_000},
    "espeak": {"voice": "en-us"},
    "language": {"code": "en_US"},
    "speaker_id_map": {"ann": 1, "bea": 2},
}


def fake_piper(folder: Path, environment: pytest.MonkeyPatch) -> None:
    """Put a program `piper` into a folder, and that into PATH."""
    program = folder / "piper"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m tests.support.piper_child "$@"\n')
    program.chmod(0o755)
    environment.setenv("PATH", f"{folder}:{os.environ['PATH']}")
    environment.setenv("PYTHONPATH", f"{ROOT}:{os.environ.get('PYTHONPATH', '')}")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a program `piper`, and a voice."""
    fake_piper(tmp_path, monkeypatch)
    voice = tmp_path / "ann.onnx"
    voice.write_bytes(b"a model")
    describe(voice)
    return tmp_path


def describe(voice: Path, **changed: object) -> None:
    voice.with_name(voice.name + ".json").write_text(json.dumps({**DESCRIPTION, **changed}))


@pytest.fixture
async def piper(folder: Path) -> AsyncIterator[Piper]:
    async with asyncio.timeout(60), Piper(VoiceSettings(file=folder / "ann.onnx")) as piper:
        yield piper


def running() -> list[psutil.Process]:
    return [
        child
        for child in psutil.Process().children(recursive=True)
        if "tests.support.piper_child" in " ".join(child.cmdline())
    ]


async def test_a_text_is_spoken_with_the_rate_of_its_voice(piper: Piper) -> None:
    assert piper.available() == (True, "")
    assert await piper.languages() == ("en-us",)
    assert await piper.voices() == ("ann", "bea")
    async with piper.speak(SpeechRequest("Good day.\nHow are you?", volume=100)) as chunks:
        speech = await collect_speech(chunks)
    assert 1 < speech.duration < 4
    assert np.abs(speech.samples).max() > 5000
    assert running() == []


async def test_the_first_sentence_is_heard_while_the_second_one_is_made(piper: Piper) -> None:
    async with piper.speak(SpeechRequest("Good day. hang. Never said.")) as chunks:
        first = await anext(chunks)
        assert len(first.samples) > 0
        assert running()
    assert running() == []


async def test_a_speaker_is_chosen_by_its_name(folder: Path) -> None:
    async with Piper(VoiceSettings(file=folder / "ann.onnx", names=("bea",))) as piper:
        assert await piper.voices() == ("bea",)
        async with piper.speak(SpeechRequest("Good day.")) as chunks:
            assert (await collect_speech(chunks)).duration > 0.3
        with pytest.raises(SpeechRefused, match="the voice 'carl' is not available"):
            async with piper.speak(SpeechRequest("Good day.", voice="carl")):
                pass


async def test_the_text_is_no_argument_of_the_process(piper: Piper) -> None:
    async with piper.speak(SpeechRequest("Top secret. hang.")) as chunks:
        await anext(chunks)
        assert all("secret" not in " ".join(process.cmdline()) for process in running())


async def test_a_process_that_dies_or_hangs_fails_this_text_alone(
    piper: Piper, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(SpeechUnavailable, match=r"piper ended with status 1: .*out of memory"):
        async with piper.speak(SpeechRequest("Good day. die.")) as chunks:
            await collect_speech(chunks)
    monkeypatch.setattr(module, "STALL_TIMEOUT", 0.3)
    with pytest.raises(SpeechUnavailable, match=r"piper gave nothing for 0\.3 s, and was ended"):
        async with piper.speak(SpeechRequest("Good day. hang.")) as chunks:
            await collect_speech(chunks)
    assert running() == []
    async with piper.speak(SpeechRequest("Good day.")) as chunks:
        assert (await collect_speech(chunks)).duration > 0.3


async def test_what_is_missing_is_named(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def reason(file: Path | None) -> str:
        works, reason = Piper(VoiceSettings(file=file)).available()
        assert not works
        return reason

    voice = folder / "ann.onnx"
    assert reason(None) == "a voice of Piper needs its file: --voice-file VOICE.onnx"
    assert reason(folder / "none.onnx") == f"--voice-file: there is no file {folder / 'none.onnx'}"
    wrong: list[dict[str, object]] = [{"audio": {}}, {"audio": 1}, {"speaker_id_map": {"a": "b"}}, {"language": 1}]
    for description in wrong:
        describe(voice, **description)
        assert reason(voice) == f"--voice-file: {voice}.json is no description of a voice of Piper"
    voice.with_name("ann.onnx.json").unlink()
    assert "ann.onnx.json, which has to be beside it: No such file" in reason(voice)
    describe(voice)
    monkeypatch.setenv("PATH", "/nowhere")
    assert reason(voice).startswith("the program piper is not installed: run `pipx install piper-tts` (GPL-3.0)")
    with pytest.raises(SpeechUnavailable, match="the program piper is not installed"):
        async with Piper(VoiceSettings(file=voice)).speak(SpeechRequest("a")):
            pass


async def test_a_rate_that_is_not_played_is_named(folder: Path) -> None:
    describe(folder / "ann.onnx", audio={"sample_rate": 12_345})
    with pytest.raises(SpeechUnavailable, match="sound of 12345 Hz is not played"):
        async with Piper(VoiceSettings(file=folder / "ann.onnx")).speak(SpeechRequest("a")):
            pass


@pytest.mark.skipif(
    shutil.which("piper") is None or "PIPER_VOICE" not in os.environ,
    reason="piper is not installed, or PIPER_VOICE names no voice of it",
)
async def test_the_real_program_speaks() -> None:
    async with Piper(VoiceSettings(file=Path(os.environ["PIPER_VOICE"]))) as piper:
        assert piper.available() == (True, "")
        async with piper.speak(SpeechRequest("Good day. How are you?")) as chunks:
            first = await anext(chunks)
            speech = await collect_speech(chunks)
    assert len(first.samples) > 0
    assert 0.3 < speech.duration < 10


def test_nothing_of_piper_is_imported() -> None:
    sources = [path for path in (ROOT / "bodies").rglob("*.py") if "import piper" in path.read_text()]
    assert sources == []
