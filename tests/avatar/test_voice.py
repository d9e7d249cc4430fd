"""The voice: sound, mouth and end of a text, on a clock turned by hand."""

import asyncio

import pytest
from openrois_avatar.body import Body
from openrois_avatar.link.messages import Command, Silence, Speak
from openrois_avatar.sound import AvatarSound
from openrois_avatar.voice import Voice

from openrois.errors import BadParameter, ComponentFailed, OutOfResources
from tests.support.streaming import VirtualClock, settle
from tests.support.voice import ScriptedSynthesizer


class Speaker:
    def __init__(self) -> None:
        self.clock = VirtualClock()
        self.synthesizer = ScriptedSynthesizer()
        self.told: list[Command] = []
        self.voice = Voice(self.synthesizer, AvatarSound(self.clock), Body(self.told.append))

    def say(self, text: str = "Hello") -> "asyncio.Future[None]":
        return asyncio.ensure_future(self.voice.say(text, ssml=False, language="en", character="default", volume=50))


@pytest.fixture
def speaker() -> Speaker:
    return Speaker()


async def test_a_text_ends_at_its_last_sample_and_the_mouth_starts_with_the_first(speaker: Speaker) -> None:
    saying = speaker.say()
    await settle()
    (speak,) = speaker.told
    assert isinstance(speak, Speak)
    lead = speak.start_ns / 1e9 - speaker.clock.now()
    assert 0.04 <= lead <= 0.06
    await speaker.clock.advance(lead + 0.99)
    assert not saying.done()
    await speaker.clock.advance(0.02)
    await saying
    assert speaker.told == [speak]


async def test_cancelling_cuts_voice_and_mouth(speaker: Speaker) -> None:
    saying = speaker.say()
    await speaker.clock.advance(0.5)
    saying.cancel()
    with pytest.raises(asyncio.CancelledError):
        await saying
    assert speaker.told[1:] == [Silence()]
    # The next text need not wait for the rest of the one that was cut.
    speaker.say()
    await settle()
    speak = speaker.told[-1]
    assert isinstance(speak, Speak)
    assert speak.start_ns / 1e9 - speaker.clock.now() <= 0.06


async def test_the_default_character_is_the_languages_own_voice(speaker: Speaker) -> None:
    assert list(await speaker.voice.characters()) == ["default", "f1", "m1"]
    speaker.say()
    await settle()
    await speaker.clock.advance(2.0)
    german = asyncio.ensure_future(speaker.voice.say("<speak/>", ssml=True, language="de", character="m1", volume=80))
    await speaker.clock.advance(2.0)
    await german
    assert speaker.synthesizer.asked == [("Hello", "en", None, 50, False), ("<speak/>", "de", "m1", 80, True)]


async def test_what_cannot_be_spoken_is_a_bad_parameter(speaker: Speaker) -> None:
    speaker.synthesizer.refuses = True
    with pytest.raises(BadParameter, match="nobody speaks that"):
        await speaker.say()
    assert speaker.told == []


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
    for each in saying:
        each.cancel()
    await asyncio.gather(*saying, return_exceptions=True)
