"""SpeechProgress as an engine sees it, beside SpeechSynthesis."""

import asyncio
from collections.abc import Callable

import numpy as np
import pytest
from openrois_body.body import Body
from openrois_body.components.speech_progress import SpeechProgress
from openrois_body.components.speech_synthesis import SpeechSynthesis
from openrois_body.hearing.ear import Ear
from openrois_body.hearing.speech_detector import SpeechDetector
from openrois_body.messages import Command, Silence
from openrois_body.sound.mixer import BodySound
from openrois_body.speech.synthesizer import Synthesizer
from openrois_body.speech.voice import Voice
from openrois_media.devices import Microphone
from openrois_streaming.source.source import RawAudio

from openrois.aio.listeners import Listeners
from openrois.contract import Event, SubscriptionLost
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted
from openrois.types.codes import ComponentFunction
from openrois.types.messages import Argument, Result
from tests.support.streaming import VirtualClock, settle
from tests.support.voice import ScriptedSynthesizer

PROGRESS, SYNTHESIS = "avatar/speech_progress", "avatar/speech_synthesizer"


class Attention:
    """Speech to the avatar, made by the test, for callers that attend."""

    def __init__(self) -> None:
        self.speech_began: Listeners[float] = Listeners()
        self.attending = 0

    def attend(self) -> Callable[[], None]:
        self.attending += 1
        return self._desert

    def _desert(self) -> None:
        self.attending -= 1


class Stage:
    def __init__(self, hearing: SpeechDetector | None = None) -> None:
        self.clock = VirtualClock()
        self.synthesizer = ScriptedSynthesizer()
        self.attention = Attention()
        self.commands: list[Command] = []
        self.voice = voice = Voice(self.synthesizer, BodySound(self.clock), Body(self.commands.append))
        self.component = SpeechProgress(voice, hearing or self.attention)
        self.registry = LocalRegistry("avatar", [SpeechSynthesis(voice), self.component])
        self.events: list[tuple[str, dict[str, str]]] = []

    async def subscribe(self) -> None:
        for event_type in ("speech_began", "word_spoken", "mark_reached", "speech_starved", "speech_ended"):
            await self.registry.subscribe(PROGRESS, event_type, self._take)

    def _take(self, event: Event | SubscriptionLost) -> None:
        assert isinstance(event, Event)
        self.events.append((event.event_type, {result.name: result.value for result in event.results}))

    async def set(self, component_ref: str, **values: str) -> None:
        arguments = tuple(Argument(name=name, data_type_ref="string", value=value) for name, value in values.items())
        await self.registry.invoke(component_ref, "set_parameter", arguments)

    async def start(self, text: str) -> "asyncio.Future[tuple[Result, ...]]":
        await self.set(SYNTHESIS, speech_text=text)
        starting = asyncio.ensure_future(self.registry.invoke(SYNTHESIS, "start"))
        await settle()
        return starting


@pytest.fixture
async def stage() -> Stage:
    stage = Stage()
    await stage.subscribe()
    return stage


async def test_each_word_is_an_event_with_its_place_and_its_time(stage: Stage) -> None:
    speaking = await stage.start("one <here> two")
    await stage.clock.advance(1.5)
    await speaking
    (began, text), *rest = stage.events
    kinds, values = zip(*rest, strict=True)
    assert (began, text["text"], text["is_ssml"]) == ("speech_began", "one <here> two", "false")
    assert text["speech_id"] == values[0]["speech_id"]
    assert text["began_at"] == values[0]["spoken_at"]
    assert kinds == ("word_spoken", "mark_reached", "word_spoken", "speech_ended")
    speech_id = values[0]["speech_id"]
    assert values[0] | {"spoken_at": ""} == {
        "speech_id": speech_id,
        "word": "one",
        "position": "0",
        "length": "3",
        "spoken_at": "",
    }
    assert values[0]["spoken_at"].startswith("2027-01-15T08:00:00.2")
    assert (values[1]["mark"], values[2]["word"], values[2]["position"]) == ("here", "two", "11")
    assert values[3] | {"ended_at": ""} == {
        "speech_id": speech_id,
        "status": "OK",
        "word": "two",
        "position": "11",
        "ended_at": "",
        "heard_ms": "1000",
    }


async def test_stop_says_at_which_word(stage: Stage) -> None:
    speaking = await stage.start("one two")
    await stage.clock.advance(0.7)
    await stage.registry.invoke(SYNTHESIS, "stop")
    sentence = "the speech was stopped at the word 'two' (character 4)"
    with pytest.raises(Aborted) as stopped:
        await speaking
    assert str(stopped.value) == sentence
    kind, values = stage.events[-1]
    assert (kind, values["status"], values["word"], values["reason"]) == ("speech_ended", "ABORT", "two", sentence)


async def test_another_start_ends_a_text_too(stage: Stage) -> None:
    first = await stage.start("one two")
    await stage.clock.advance(0.3)
    second = await stage.start("three")
    with pytest.raises(Aborted):
        await first
    assert stage.events[-1][1]["reason"] == "the speech was stopped at the word 'one' (character 0)"
    await stage.clock.advance(1.5)
    assert await second == ()


async def test_suspended_it_is_silent_until_it_is_resumed(stage: Stage) -> None:
    speaking = await stage.start("one two")
    await stage.clock.advance(0.3)
    await stage.registry.invoke(SYNTHESIS, "suspend")
    await settle()
    assert stage.commands[-1] == Silence()
    await stage.clock.advance(10)
    assert not speaking.done()
    assert (await stage.registry.query(SYNTHESIS, "component_status"))[0].value == "BUSY"
    await stage.registry.invoke(SYNTHESIS, "resume")
    await stage.clock.advance(1.5)
    assert await speaking == ()
    assert [values["word"] for kind, values in stage.events if kind == "word_spoken"] == ["one", "two"]


async def test_speech_interrupts_only_with_barge_in(stage: Stage) -> None:
    speaking = await stage.start("one two")
    await stage.clock.advance(0.3)
    stage.attention.speech_began.notify_all(stage.clock.now())
    await stage.clock.advance(1.0)
    assert await speaking == ()


async def test_barge_in_stops_the_speech(stage: Stage) -> None:
    await stage.set(PROGRESS, barge_in="true")
    speaking = await stage.start("one two")
    await stage.clock.advance(0.3)
    stage.attention.speech_began.notify_all(stage.clock.now())
    await settle()
    assert stage.commands[-1] == Silence()
    with pytest.raises(Aborted, match=r"a person spoke, and the speech stopped at the word 'one' \(character 0\)"):
        await speaking
    stage.attention.speech_began.notify_all(stage.clock.now())
    assert len([kind for kind, _ in stage.events if kind == "speech_ended"]) == 1


@pytest.mark.engine
async def test_a_real_voice_in_the_microphone_barges_in() -> None:
    microphone = Microphone(VirtualClock())
    stage = Stage(SpeechDetector(Ear(microphone, VirtualClock())))
    async with Synthesizer() as synthesizer:
        said = (await synthesizer.synthesize("Excuse me, may I ask you something?", volume=80)).samples
    await stage.set(PROGRESS, barge_in="true")
    speaking = await stage.start("one two")
    await stage.clock.advance(0.3)
    sound = np.concatenate((np.zeros(24_000, np.int16), said))[:, np.newaxis].repeat(2, axis=1)
    for first in range(0, len(sound), 480):
        microphone.sound_to_recognise.notify_all(RawAudio(sound[first : first + 480], first / 48_000))
        if first < 24_000:
            assert Silence() not in stage.commands
    await settle()
    assert stage.commands[-1] == Silence()
    with pytest.raises(Aborted, match="a person spoke, and the speech stopped at the word 'one'"):
        await speaking


async def test_speech_is_detected_only_while_barge_in_is_set(stage: Stage) -> None:
    attending = []
    for barge_in in ("false", "true", "true", "false", "false", "true"):
        await stage.set(PROGRESS, barge_in=barge_in)
        attending.append(stage.attention.attending)
    assert attending == [0, 1, 1, 0, 0, 1]


async def test_only_the_application_with_the_binding_sets_barge_in(stage: Stage) -> None:
    assert stage.component.profile.function is ComponentFunction.ACTUATION


async def test_the_standards_component_stays_the_standards(stage: Stage) -> None:
    directory = await stage.registry.discover()
    profile = directory.component_profiles[SYNTHESIS]
    assert profile.event_profiles == ()
    assert {parameter.name for parameter in profile.parameter_profiles} == {
        "speech_text",
        "ssml_text",
        "volume",
        "language",
        "character",
    }


async def test_a_stream_is_told_of_as_a_text_is_and_where_it_runs_dry(stage: Stage) -> None:
    stream = stage.voice.make_utterance("one two")
    speaking = asyncio.ensure_future(stage.voice.utter(stream))
    stream.push(np.full(24_000, 8_000, np.int16))
    await stage.clock.advance(1.0)
    stage.voice.interrupt("a person spoke, and the speech stopped")
    with pytest.raises(Aborted):
        await speaking
    kinds, values = zip(*stage.events, strict=True)
    assert kinds == ("speech_began", "speech_starved", "speech_ended")
    assert len({each["speech_id"] for each in values}) == 1
    assert (values[0]["text"], values[1]["heard_ms"], values[2]["heard_ms"]) == ("one two", "500", "500")
    assert (values[2]["status"], "word" in values[2]) == ("ABORT", False)
