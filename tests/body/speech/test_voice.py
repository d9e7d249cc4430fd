"""The voice: sound, mouth, words and end of a text, on a clock turned by hand."""

import asyncio
from collections.abc import AsyncIterator

import numpy as np
import pytest
from openrois_body.body import Body
from openrois_body.messages import Command, Silence, Speak
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.playout_delay import PLAYOUT
from openrois_body.speech.progress import MarkReached, Progress, SpeechBegan, SpeechEnded, WordSpoken
from openrois_body.speech.voice import Voice
from openrois_streaming.source.source import RawAudio

from openrois.errors import Aborted, BadParameter, ComponentFailed, OutOfResources
from openrois.types.codes import CompletedStatus
from tests.support.streaming import VirtualClock, settle
from tests.support.voice import ScriptedSynthesizer


class Speaker:
    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.synthesizer = ScriptedSynthesizer()
        self.told: list[Command] = []
        self.body = Body(self.told.append)
        self.sound = BodySound(self.clock)
        self.voice = Voice(self.synthesizer, self.sound, self.body)
        self.progress: list[Progress] = []
        self.at: list[float] = []
        self.voice.progress.add(self._take)

    def _take(self, progress: Progress) -> None:
        self.progress.append(progress)
        self.at.append(self.clock.now())

    def say(self, text: str = "Hello") -> "asyncio.Future[None]":
        return asyncio.ensure_future(self.voice.say(text, ssml=False, language="en", character="default", volume=50))

    def speaks(self) -> list[Speak]:
        return [command for command in self.told if isinstance(command, Speak)]

    def words(self) -> list[tuple[str, int]]:
        return [(each.word, each.position) for each in self.progress if isinstance(each, WordSpoken)]

    def end(self) -> SpeechEnded:
        (end,) = (each for each in self.progress if isinstance(each, SpeechEnded))
        return end

    async def listen(self, blocks: list[RawAudio]) -> None:
        """Hear everything, as a reader that is in time."""
        async with self.sound.open() as source:
            async for block in source:
                blocks.append(block)


@pytest.fixture
def speaker() -> Speaker:
    return Speaker()


@pytest.fixture
async def heard(speaker: Speaker) -> AsyncIterator[list[RawAudio]]:
    blocks: list[RawAudio] = []
    listening = asyncio.create_task(speaker.listen(blocks))
    yield blocks
    listening.cancel()
    await asyncio.wait({listening})


async def test_the_mouth_starts_with_the_first_sample_and_a_text_ends_when_the_last_was_heard(speaker: Speaker) -> None:
    saying = speaker.say()
    await settle()
    (speak,) = speaker.speaks()
    lead = speak.start_ns / 1e9 - speaker.clock.now()
    assert 0.04 <= lead <= 0.06
    await speaker.clock.advance(lead + 1.0 + PLAYOUT - 0.001)
    assert not saying.done()
    await speaker.clock.advance(0.002)
    await saying
    assert speaker.told == [speak]


async def test_where_the_engines_sound_is_waited_for_a_text_ends_so_much_later(
    speaker: Speaker, heard: list[RawAudio]
) -> None:
    await settle()
    # 0.097 s after the moment of its block, and 3 ms are allowed for.
    speaker.sound.feed(RawAudio(np.zeros((960, 1), np.int16), speaker.clock.now() - 0.097))
    saying = speaker.say()
    await settle()
    lead = speaker.speaks()[0].start_ns / 1e9 - speaker.clock.now()
    assert 0.1 <= speaker.sound.lag <= 0.11
    await speaker.clock.advance(lead + 1.0 + speaker.sound.lag + PLAYOUT - 0.002)
    assert not saying.done()
    assert heard[-1].captured_at < speaker.clock.now() - 0.09
    await speaker.clock.advance(0.004)
    await saying


async def test_words_and_marks_are_told_when_they_are_heard(speaker: Speaker) -> None:
    saying = speaker.say("one <here> two  three")
    await settle()
    begin = speaker.speaks()[0].start_ns / 1e9 + PLAYOUT
    await speaker.clock.advance(1.5)
    await saying
    kinds = [SpeechBegan, WordSpoken, MarkReached, WordSpoken, WordSpoken, SpeechEnded]
    assert [type(each) for each in speaker.progress] == kinds
    began = speaker.progress[0]
    assert isinstance(began, SpeechBegan)
    assert (began.text, began.is_ssml) == ("one <here> two  three", False)
    assert speaker.words() == [("one", 0), ("two", 11), ("three", 16)]
    assert speaker.at == pytest.approx([begin, begin, begin + 0.25, begin + 0.5, begin + 0.75, begin + 1.0])
    walls = [each.at - speaker.clock.wall() + speaker.clock.now() for each in speaker.progress]
    assert walls == pytest.approx(speaker.at)
    assert len({each.speech_id for each in speaker.progress}) == 1
    end = speaker.end()
    assert (end.status, end.reason, end.last and end.last.text) == (CompletedStatus.OK, "", "three")


async def test_interrupting_cuts_voice_mouth_and_what_waits_and_says_at_which_word(
    speaker: Speaker, heard: list[RawAudio]
) -> None:
    saying, waiting = speaker.say("one two"), speaker.say("three")
    await speaker.clock.advance(0.7)
    now = speaker.clock.now()
    speaker.voice.interrupt("a person spoke")
    await speaker.voice.silent()
    with pytest.raises(Aborted, match=r"^a person spoke at the word 'two' \(character 4\)$"):
        await saying
    with pytest.raises(Aborted, match=r"^a person spoke before its first sound$"):
        await waiting
    assert speaker.clock.now() == now
    assert speaker.told[1:] == [Silence()]
    first, second = (each for each in speaker.progress if isinstance(each, SpeechEnded))
    assert (first.status, first.last and first.last.text, second.last) == (CompletedStatus.ABORT, "two", None)
    await speaker.clock.advance(2.0)
    loud = [block.captured_at + index / 48_000 for block in heard for index in np.flatnonzero(block.samples)]
    assert max(loud) < now + 0.025


async def test_words_that_are_on_their_way_are_told_before_the_end(speaker: Speaker) -> None:
    saying = speaker.say("one two")
    await settle()
    begin = speaker.speaks()[0].start_ns / 1e9
    # "two" has begun, and is not heard yet.
    await speaker.clock.advance(begin + 0.55 - speaker.clock.now())
    assert speaker.words() == [("one", 0)]
    speaker.voice.interrupt("enough")
    with pytest.raises(Aborted, match="enough at the word 'two'"):
        await saying
    assert speaker.words() == [("one", 0), ("two", 4)]
    assert speaker.progress[2].at - speaker.clock.wall() == pytest.approx(PLAYOUT - 0.05)


async def test_cancelling_cuts_voice_and_mouth(speaker: Speaker) -> None:
    saying = speaker.say()
    await speaker.clock.advance(0.5)
    saying.cancel()
    with pytest.raises(asyncio.CancelledError):
        await saying
    assert speaker.told[1:] == [Silence()]
    assert speaker.end().reason == "the speech was stopped at the word 'Hello' (character 0)"
    # The next text need not wait for the rest of the one that was cut.
    speaker.say()
    await settle()
    speak = speaker.told[-1]
    assert isinstance(speak, Speak)
    assert speak.start_ns / 1e9 - speaker.clock.now() <= 0.06


async def test_a_text_that_is_interrupted_before_there_is_any_sound_is_not_heard(speaker: Speaker) -> None:
    speaker.synthesizer.ready.clear()
    saying = speaker.say()
    await settle()
    speaker.voice.interrupt("a person spoke")
    await speaker.voice.silent()
    with pytest.raises(Aborted, match="a person spoke before its first sound"):
        await saying
    assert speaker.speaks() == []


async def test_paused_in_mid_word_it_goes_on_where_it_was(speaker: Speaker, heard: list[RawAudio]) -> None:
    saying = speaker.say("one two three four")
    await speaker.clock.advance(0.5)
    speaker.voice.pause()
    await speaker.clock.advance(5.0)
    assert not saying.done()
    assert speaker.told[1:] == [Silence()]
    assert speaker.words() == [("one", 0), ("two", 4)]
    silent = heard[-1].captured_at
    speaker.voice.go_on()
    await settle()
    first, second = speaker.speaks()
    assert second.start_ns / 1e9 == pytest.approx(speaker.clock.now() + 0.05, abs=0.011)
    assert first.duration_ms == 1000
    assert 500 < second.duration_ms < 560
    await speaker.clock.advance(1.0)
    await saying
    assert [word for word, _ in speaker.words()] == ["one", "two", "three", "four"]
    # What faded out is heard again, fading in; the end dies away.
    loud = sum(int(np.count_nonzero(block.samples)) for block in heard)
    assert loud == pytest.approx(48_000 + 2 * 240, abs=4)
    assert not any(block.samples.any() for block in heard if silent - 4.8 < block.captured_at <= silent)


async def test_a_paused_text_can_be_interrupted(speaker: Speaker) -> None:
    saying = speaker.say("one two")
    await speaker.clock.advance(0.3)
    speaker.voice.pause()
    await settle()
    speaker.voice.interrupt("enough")
    await speaker.voice.silent()
    with pytest.raises(Aborted, match="enough at the word 'one'"):
        await saying
    speaker.voice.pause()
    assert not speaker.say().done()
    await speaker.clock.advance(1.5)
    assert speaker.words()[-1] == ("Hello", 0)


async def test_a_game_engine_that_comes_back_moves_the_mouth_of_what_is_said(speaker: Speaker) -> None:
    saying = speaker.say()
    await speaker.clock.advance(0.5)
    speaker.body.engine_returned(())
    assert speaker.told == [speaker.speaks()[0]] * 2
    await speaker.clock.advance(1.0)
    await saying
    speaker.body.engine_returned(())
    assert len(speaker.told) == 2


async def test_the_default_character_is_the_languages_own_voice(speaker: Speaker) -> None:
    assert list(await speaker.voice.characters()) == ["default", "f1", "m1"]
    speaker.say()
    await settle()
    await speaker.clock.advance(2.0)
    german = asyncio.ensure_future(speaker.voice.say("<speak/>", ssml=True, language="de", character="m1", volume=80))
    await speaker.clock.advance(2.0)
    await german
    assert speaker.synthesizer.asked == [("Hello", "en", None, 50, False), ("<speak/>", "de", "m1", 80, True)]


async def test_refused_text_is_a_bad_parameter(speaker: Speaker) -> None:
    speaker.synthesizer.refuses = True
    with pytest.raises(BadParameter, match="not available"):
        await speaker.say()
    assert speaker.told == []
    assert speaker.end().reason == "not available; the speech ended before its first sound"
    assert speaker.progress == [speaker.end()]


async def test_without_synthesis_it_says_what_to_install(speaker: Speaker) -> None:
    speaker.synthesizer.installed = False
    assert speaker.voice.available() == (False, "install it")
    for asked in (speaker.say(), speaker.voice.languages(), speaker.voice.characters()):
        with pytest.raises(ComponentFailed, match="install it"):
            await asked


async def test_too_many_texts_at_once_are_refused(speaker: Speaker) -> None:
    saying = [speaker.say() for _ in range(32)]
    await settle()
    with pytest.raises(OutOfResources):
        await speaker.say()
    assert speaker.end().status == CompletedStatus.OUT_OF_RESOURCES
    for each in saying:
        each.cancel()
    await asyncio.gather(*saying, return_exceptions=True)
