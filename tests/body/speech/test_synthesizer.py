import asyncio
import importlib.util
import os
import signal

import numpy as np
import pytest
import uvloop
from openrois_body.messages import Viseme
from openrois_body.speech import synthesizer as module
from openrois_body.speech.contract import (
    NamedMark,
    Speech,
    SpeechRefused,
    SpeechRequest,
    SpeechUnavailable,
    Word,
    collect_speech,
)
from openrois_body.speech.synthesizer import Synthesizer

pytestmark = pytest.mark.extra(name="speech")


def test_rest_of_a_speech_continues_where_it_was_cut() -> None:
    samples = np.full(4800, 1000, np.int16)
    words = (Word(0.0, "a", 0), Word(50.0, "b", 2), Word(80.0, "c", 4))
    shapes = (Viseme(0.0, "aa", 0.5), Viseme(40.0, "PP", 1.0), Viseme(60.0, "sil", 1.0))
    whole = Speech(samples, words, shapes, (NamedMark(20.0, "x"), NamedMark(80.0, "y")))
    rest = whole.after(2400)
    assert rest.duration == 0.05
    assert rest.words == (Word(0.0, "b", 2), Word(30.0, "c", 4))
    assert rest.marks == (NamedMark(30.0, "y"),)
    assert rest.visemes == (Viseme(0.0, "PP", 1.0), Viseme(10.0, "sil", 1.0))
    assert rest.samples[0] < 10
    assert set(rest.samples[240:]) == {1000}
    assert whole.samples[2400] == 1000
    nothing = whole.after(4800)
    assert (len(nothing.samples), nothing.words) == (0, ())
    assert nothing.visemes == (Viseme(0.0, "sil", 1.0),)


async def test_without_the_library_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda _name: None)
    sentence = "speech synthesis is not installed: run `pip install 'openrois[speech]'`"
    async with Synthesizer() as synthesizer:
        assert synthesizer.available() == (False, sentence)
        with pytest.raises(SpeechUnavailable) as refused:
            await synthesizer.synthesize("Hello")
        assert str(refused.value) == sentence
        with pytest.raises(SpeechUnavailable):
            await synthesizer.languages()


def test_with_the_library_it_is_available() -> None:
    assert Synthesizer().available() == (True, "")


@pytest.fixture
def _fake(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_CHILD", "tests.support.fake_speech")


async def refusal(synthesizer: Synthesizer, text: str) -> str:
    with pytest.raises(SpeechRefused) as refused:
        await synthesizer.synthesize(text)
    return str(refused.value)


async def pid_of(synthesizer: Synthesizer) -> int:
    """The fake puts its process id into its refusals."""
    return int((await refusal(synthesizer, "pid")).removeprefix("pid "))


@pytest.mark.engine
@pytest.mark.usefixtures("_fake")
async def test_the_process_is_kept_and_ended_with_the_context() -> None:
    async with asyncio.timeout(60), Synthesizer() as synthesizer:
        pid = await pid_of(synthesizer)
        assert await pid_of(synthesizer) == pid
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.engine
@pytest.mark.usefixtures("_fake")
async def test_a_process_that_died_in_the_meantime_is_replaced() -> None:
    async with asyncio.timeout(60), Synthesizer() as synthesizer:
        pid = await pid_of(synthesizer)
        os.kill(pid, signal.SIGKILL)
        assert await pid_of(synthesizer) != pid


@pytest.mark.engine
@pytest.mark.usefixtures("_fake")
def test_process_with_a_noticed_end_is_replaced_under_uvloop() -> None:
    async def speak() -> None:
        async with asyncio.timeout(60), Synthesizer() as synthesizer:
            pid = await pid_of(synthesizer)
            process = synthesizer._process
            assert process is not None
            assert process.stdin is not None
            os.kill(pid, signal.SIGKILL)
            await process.wait()
            while not process.stdin.is_closing():  # noqa: ASYNC110 - the pipe has no event
                await asyncio.sleep(0)
            assert await pid_of(synthesizer) != pid

    uvloop.run(speak())


@pytest.mark.engine
@pytest.mark.usefixtures("_fake")
@pytest.mark.parametrize("text", ["die", "babble", "flood"])
async def test_a_text_that_breaks_the_process_fails_alone(text: str) -> None:
    async with asyncio.timeout(60), Synthesizer() as synthesizer:
        with pytest.raises(SpeechUnavailable, match="the speech process died over this text") as failed:
            await synthesizer.synthesize(text)
        assert ("out of memory" in str(failed.value)) is (text == "die")
        assert await refusal(synthesizer, "next")


@pytest.mark.engine
@pytest.mark.usefixtures("_fake")
async def test_a_process_that_hangs_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    async with asyncio.timeout(60), Synthesizer() as synthesizer:
        pid = await pid_of(synthesizer)
        monkeypatch.setattr(module, "ANSWER_TIMEOUT", 0.02)
        with pytest.raises(SpeechUnavailable, match=r"did not answer within 0\.02 seconds"):
            await synthesizer.synthesize("hang")
        monkeypatch.undo()
        monkeypatch.setattr(module, "_CHILD", "tests.support.fake_speech")
        assert await pid_of(synthesizer) != pid


@pytest.mark.engine
@pytest.mark.usefixtures("_fake")
async def test_a_request_that_is_given_up_does_not_disturb_the_next() -> None:
    async with asyncio.timeout(20), Synthesizer() as synthesizer:
        await pid_of(synthesizer)
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(0.02):
                await synthesizer.synthesize("hang")
        assert await refusal(synthesizer, "next")


@pytest.mark.engine
async def test_a_sentence_becomes_sound_words_and_movement() -> None:
    async with asyncio.timeout(60), Synthesizer() as synthesizer:
        spoken = await synthesizer.synthesize("Hello world, I am your avatar.", volume=100)
        quiet = await synthesizer.synthesize("Hello world, I am your avatar.", volume=25)
        silent = await synthesizer.synthesize("Hello world, I am your avatar.", volume=0)
        other = await synthesizer.synthesize("Hello world, I am your avatar.", voice="f3", rate=300)
    assert spoken.samples.dtype == np.int16
    assert 1.2 < spoken.duration < 2.5
    assert [word.text for word in spoken.words] == ["Hello", "world", "I", "your", "avatar"]
    assert [word.position for word in spoken.words] == [0, 6, 13, 18, 23]
    assert [word.offset_ms for word in spoken.words] == sorted(word.offset_ms for word in spoken.words)
    assert spoken.visemes[-1].shape == "sil"
    assert len({viseme.shape for viseme in spoken.visemes}) > 6
    assert all(viseme.offset_ms <= spoken.duration * 1000 for viseme in spoken.visemes)
    peak = int(np.abs(spoken.samples.astype(int)).max())
    assert 20_000 < peak < 32_768
    assert int(np.abs(quiet.samples.astype(int)).max()) == pytest.approx(peak / 4, rel=0.1)
    assert not silent.samples.any()
    assert other.duration < spoken.duration * 0.75


@pytest.mark.engine
async def test_the_mouth_moves_when_there_is_sound() -> None:
    async with asyncio.timeout(60), Synthesizer() as synthesizer:
        spoken = await synthesizer.synthesize("Papa ... mama.", volume=100)
    loudness = [
        float(np.abs(spoken.samples[round(viseme.offset_ms * 48) :][:1920].astype(float)).mean())
        for viseme in spoken.visemes
    ]
    open_mouth = [level for level, viseme in zip(loudness, spoken.visemes, strict=True) if viseme.shape == "aa"]
    closed = [level for level, viseme in zip(loudness[:-1], spoken.visemes, strict=False) if viseme.shape == "sil"]
    assert min(open_mouth) > 10 * max(closed)


@pytest.mark.engine
async def test_languages_and_voices_are_reported() -> None:
    async with asyncio.timeout(60), Synthesizer() as synthesizer:
        languages, voices = await synthesizer.languages(), await synthesizer.voices()
        assert {"en", "en-us", "de", "ja", "es", "fr"} <= set(languages)
        assert {"f3", "m1"} <= set(voices)
        assert (await synthesizer.synthesize("Servus", language="de-AT")).duration > 0.2
        with pytest.raises(SpeechRefused, match="the language 'xx' is not available"):
            await synthesizer.synthesize("Hello", language="xx")
        with pytest.raises(SpeechRefused, match="the voice 'alien' is not available"):
            await synthesizer.synthesize("Hello", voice="alien")


@pytest.mark.engine
async def test_a_text_that_is_left_lets_the_process_live_and_the_next_one_be_spoken() -> None:
    async with asyncio.timeout(60), Synthesizer() as synthesizer:
        await synthesizer.voices()
        process = synthesizer._process
        for _ in range(3):
            async with synthesizer.speak(SpeechRequest("This is a very long text. " * 150)) as chunks:
                await anext(chunks)
        spoken = await synthesizer.synthesize("one")
        assert spoken.duration < 1.5
        assert [word.text for word in spoken.words] == ["one"]
        assert synthesizer._process is process


@pytest.mark.engine
async def test_a_text_that_is_left_before_its_turn_leaves_the_others_alone() -> None:
    async with asyncio.timeout(60), Synthesizer() as synthesizer:
        await synthesizer.voices()
        process = synthesizer._process
        async with synthesizer.speak(SpeechRequest("This is a very long text. " * 100)) as chunks:
            async with synthesizer.speak(SpeechRequest("two")):
                pass
            whole = await collect_speech(chunks)
        assert [word.text for word in whole.words][-1:] == ["text"]
        assert whole.duration > 60
        assert synthesizer._process is process
