"""The components of the operator's microphone, with a microphone that is fed by hand."""

import asyncio
import math
from collections.abc import AsyncIterator

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.components.sound_localization import ASSUMED_DISTANCE
from openrois_body.hearing.recognizer import OTHER_SPEECH, Expectation
from openrois_body.microphone_senses import microphone_senses
from openrois_streaming.source.source import SAMPLE_RATE

from openrois.contract import Event, Fault, SubscriptionLost
from openrois.engine.registry import LocalRegistry
from openrois.errors import BadParameter, ComponentFailed
from openrois.types.messages import Argument
from tests.support.hearing import not_speech, stereo_48k, voice
from tests.support.listening import Listened, ScriptedRecognizer
from tests.support.streaming import settle

SILENCE = np.zeros((36_000, 2), np.int16)
VOICE = stereo_48k(voice(1.0))


class Room(Listened):
    """The senses of one microphone, as applications meet them."""

    def __init__(self, recognizer: ScriptedRecognizer | None = None) -> None:
        super().__init__()
        self.recognizer = recognizer or ScriptedRecognizer()
        self.senses = microphone_senses("avatar", self.microphone, self.clock, self.recognizer)
        self.registry = LocalRegistry("avatar", self.senses.components, wall_clock=self.clock.wall)
        self.events: list[Event] = []
        self.faults: list[Fault] = []
        self.registry.on_fault = self.faults.append

    async def subscribe(self, component: str, event: str) -> str:
        return await self.registry.subscribe(f"avatar/{component}", event, self._take)

    def _take(self, item: Event | SubscriptionLost) -> None:
        assert isinstance(item, Event)
        self.events.append(item)

    async def do(self, component: str, command: str, **arguments: str) -> None:
        kinds = {"languages": "string[]", "microphone_distance": "int", "detection_threshold": "int"}
        given = (
            Argument(name=name, data_type_ref=kinds.get(name, "string"), value=value)
            for name, value in arguments.items()
        )
        await self.registry.invoke(f"avatar/{component}", command, tuple(given))

    async def ask(self, component: str, query: str) -> dict[str, str]:
        return {result.name: result.value for result in await self.registry.query(f"avatar/{component}", query)}

    def told(self, event_type: str, name: str) -> list[str]:
        """The values of one result, of all events of a type."""
        of_type = (event for event in self.events if event.event_type == event_type)
        return [result.value for event in of_type for result in event.results if result.name == name]


@pytest.fixture
async def room() -> AsyncIterator[Room]:
    room = Room()
    async with room.plugged(asyncio.ensure_future(room.senses.run())):
        yield room


class TestSoundDetection:
    async def test_a_sound_is_told_when_it_begins_and_ends(self, room: Room) -> None:
        subscription = await room.subscribe("sound_detecter", "sound_detected")
        await room.say(np.concatenate([SILENCE, VOICE, SILENCE]))
        assert room.told("sound_detected", "number") == ["1", "0"]
        await room.registry.unsubscribe(subscription)
        await room.say(np.concatenate([VOICE, SILENCE]))
        assert len(room.events) == 2

    async def test_a_sound_ends_with_the_microphone(self, room: Room) -> None:
        await room.subscribe("sound_detecter", "sound_detected")
        await room.say(np.concatenate([SILENCE, VOICE[:24_000]]))
        room.unplug()
        await room.clock.advance(1.0)
        assert room.told("sound_detected", "number") == ["1", "0"]

    async def test_a_sound_that_has_ended_meanwhile_is_told_to_be_over(self, room: Room) -> None:
        await room.subscribe("sound_detecter", "sound_detected")
        await room.say(np.concatenate([SILENCE, VOICE[:24_000]]))
        await room.do("sound_detecter", "suspend")
        await room.say(SILENCE)
        await room.do("sound_detecter", "resume")
        await room.say(SILENCE)
        assert room.told("sound_detected", "number") == ["1", "0"]

    @pytest.mark.parametrize(("pause", "go_on"), [("suspend", "resume"), ("stop", "start")])
    async def test_a_sound_that_ended_with_the_microphone_meanwhile_is_told_to_be_over(
        self, room: Room, pause: str, go_on: str
    ) -> None:
        await room.subscribe("sound_detecter", "sound_detected")
        await room.say(np.concatenate([SILENCE, VOICE[:24_000]]))
        await room.do("sound_detecter", pause)
        room.unplug()
        await room.clock.advance(1.0)
        await room.do("sound_detecter", go_on)
        await room.clock.advance(1.0)
        assert room.told("sound_detected", "number") == ["1", "0"]
        assert room.events[1].results[-1].value > room.events[0].results[-1].value

    async def test_stop_and_start(self, room: Room) -> None:
        await room.subscribe("sound_detecter", "sound_detected")
        await room.do("sound_detecter", "stop")
        await room.say(np.concatenate([SILENCE, VOICE, SILENCE]))
        assert room.events == []
        await room.do("sound_detecter", "start")
        await room.say(np.concatenate([SILENCE, VOICE, SILENCE]))
        assert room.told("sound_detected", "number") == ["1", "0"]


def from_the_side(degrees: float, distance: float, sound: NDArray[np.int16]) -> NDArray[np.int16]:
    """`sound` as two microphones at `distance` hear it; noise is different in each."""
    late = math.sin(math.radians(degrees)) * distance / 343 * SAMPLE_RATE
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(len(sound)) * late)
    left = np.fft.irfft(np.fft.rfft(sound[:, 0]) * turn, len(sound))
    noise = np.random.default_rng(3).normal(0, 10, (len(sound), 2))
    return np.clip(np.rint(np.column_stack([left, sound[:, 0]]) + noise), -32_768, 32_767).astype(np.int16)


class TestSoundLocalization:
    @pytest.mark.parametrize(("degrees", "millimetres"), [(40.0, 150), (-60.0, 80)])
    async def test_a_voice_is_where_it_is_heard_from(self, room: Room, degrees: float, millimetres: int) -> None:
        await room.do(
            "sound_localizer", "set_parameter", microphone_distance=str(millimetres), detection_threshold="100"
        )
        await room.subscribe("sound_localizer", "sound_localized")
        await room.say(np.concatenate([SILENCE, from_the_side(degrees, millimetres / 1000, VOICE), SILENCE]))
        (ref, *_), (place, *_) = (
            room.told("sound_localized", "sound_ref"),
            room.told("sound_localized", "position_data"),
        )
        assert "urn:x-rois:def:sound:OpenRoIS::avatar/microphone/1" in ref
        x, y, th = (float(number) for number in place.strip('[]"').split(","))
        assert math.degrees(math.atan2(x, y)) == pytest.approx(degrees, abs=6)
        assert math.hypot(x, y) == pytest.approx(ASSUMED_DISTANCE, abs=0.01)
        assert math.degrees(th) == pytest.approx(math.degrees(math.atan2(-y, -x)), abs=0.1)
        assert len(room.events) <= 3
        room.events.clear()
        await room.say(np.concatenate([from_the_side(0, millimetres / 1000, VOICE), SILENCE]))
        assert "microphone/2" in room.told("sound_localized", "sound_ref")[0]
        x, y, _ = (float(part) for part in room.told("sound_localized", "position_data")[0].strip('[]"').split(","))
        assert math.degrees(math.atan2(x, y)) == pytest.approx(0, abs=6), "where the sound before was is forgotten"

    async def test_a_microphone_with_one_channel_is_said_to_be_of_no_use(self, room: Room) -> None:
        await room.subscribe("sound_localizer", "sound_localized")
        await room.say(np.concatenate([SILENCE, VOICE, VOICE, VOICE, SILENCE]))
        assert room.events == []
        assert ["one channel" in fault.description for fault in room.faults] == [True]
        assert (await room.ask("hearing", "microphone"))["channels"] == "1"
        room.unplug()
        await room.clock.advance(1.0)
        room.plug()
        await room.say(np.concatenate([SILENCE, VOICE, VOICE, SILENCE]))
        assert len(room.faults) == 2

    async def test_noise_from_everywhere_has_no_place(self, room: Room) -> None:
        await room.do("sound_localizer", "start")
        await room.subscribe("sound_localizer", "sound_localized")
        noise = np.random.default_rng(1).normal(0, 3000, (48_000, 2)).astype(np.int16)
        await room.say(np.concatenate([SILENCE, noise, SILENCE]))
        assert (room.events, room.faults) == ([], [])
        await room.do("sound_localizer", "stop")


class TestSpeechRecognition:
    async def test_recognised_speech_and_its_times_are_announced(self, room: Room) -> None:
        for event in ("speech_input_started", "speech_input_finished", "speech_recognized"):
            await room.subscribe("speech_recognizer", event)
        await room.say(np.concatenate([SILENCE, VOICE, SILENCE, VOICE, SILENCE]))
        types = [event.event_type for event in room.events]
        assert types == ["speech_input_started", "speech_input_finished", "speech_recognized"] * 2
        assert room.told("speech_recognized", "recognized_text") == ['["hello", "hollow"]'] * 2
        assert room.told("speech_input_started", "timestamp")[0].startswith("2027-01-15T08:00:00.7")

    @pytest.mark.parametrize("others", [False, True])
    async def test_begun_speech_is_finished_when_the_component_is_suspended(self, room: Room, others: bool) -> None:
        for event in ("speech_input_started", "speech_input_finished", "speech_recognized"):
            await room.subscribe("speech_recognizer", event)
        if others:
            await room.do("hearing", "start")
        await room.say(np.concatenate([SILENCE, VOICE]))
        await room.do("speech_recognizer", "suspend")
        await room.say(np.concatenate([SILENCE, VOICE, SILENCE]))
        await room.do("speech_recognizer", "resume")
        await room.say(SILENCE)
        assert [event.event_type for event in room.events] == ["speech_input_started", "speech_input_finished"]

    async def test_sound_without_speech_is_not_announced(self, room: Room) -> None:
        for event in ("speech_input_started", "speech_recognized"):
            await room.subscribe("speech_recognizer", event)
        for name in ("white noise", "a tone of 440 Hz", "a melody", "a band"):
            await room.say(np.concatenate([SILENCE, stereo_48k(not_speech()[name]), SILENCE]))
            assert room.events == [], name

    async def test_present_language_and_grammar_are_used(self, room: Room) -> None:
        await room.subscribe("speech_recognizer", "speech_recognized")
        await room.say(np.concatenate([SILENCE, VOICE, SILENCE]))
        await room.do("speech_recognizer", "set_parameter", languages='["de-AT","en"]', grammar="mine", rule="first")
        await room.say(np.concatenate([VOICE, SILENCE]))
        await room.do("speech_recognizer", "set_parameter", grammar="other")
        await room.say(np.concatenate([VOICE, SILENCE]))
        assert room.recognizer.expected == [
            Expectation(("en",)),
            Expectation(("de", "en"), "mine", "first"),
            Expectation(("de", "en"), "other", "default"),
        ]
        assert (await room.ask("speech_recognizer", "recognizable_languages"))["languages"] == '["en", "de"]'

    @pytest.mark.parametrize(
        ("given", "said"),
        [
            ({"languages": '["ja"]'}, "ja cannot be recognised here; recognizable_languages has en, de"),
            ({"languages": "[]"}, "languages"),
            ({"grammar": "unknown"}, "no such grammar"),
        ],
    )
    async def test_unsupported_language_or_grammar_is_refused(
        self, room: Room, given: dict[str, str], said: str
    ) -> None:
        with pytest.raises(BadParameter, match=said):
            await room.do("speech_recognizer", "set_parameter", **given)
        assert '["en"]' in str(await room.ask("speech_recognizer", "get_parameter"))

    async def test_a_recogniser_without_english_begins_with_its_own_language(self) -> None:
        recognizer = ScriptedRecognizer()
        recognizer.languages = ("ja", "ko")
        assert '["ja"]' in str(await Room(recognizer).ask("speech_recognizer", "get_parameter"))

    async def test_without_a_recogniser_it_does_not_work(self) -> None:
        recognizer = ScriptedRecognizer()
        recognizer.installed = False
        room = Room(recognizer)
        assert (await room.ask("speech_recognizer", "component_status"))["status"] == "ERROR"
        with pytest.raises(ComponentFailed):
            await room.subscribe("speech_recognizer", "speech_recognized")

    async def test_a_recogniser_that_fails_is_reported(self, room: Room) -> None:
        await room.subscribe("speech_recognizer", "speech_recognized")
        await settle()
        room.recognizer.failures = 2
        await room.say(np.concatenate([SILENCE, VOICE, SILENCE]))
        assert [fault.description for fault in room.faults] == ["it broke"]
        await room.clock.advance(5.0)
        assert (await room.ask("speech_recognizer", "component_status"))["status"] == "READY"


class TestHearing:
    async def test_words_are_shown_while_they_come(self, room: Room) -> None:
        assert await room.ask("hearing", "last_heard") == {"text": ""}
        await room.subscribe("hearing", "heard")
        await room.say(np.concatenate([SILENCE, VOICE]))
        assert (await room.ask("hearing", "microphone")) == {"channels": "1", "speaking": "true"}
        await room.say(SILENCE)
        texts, final = room.told("heard", "text"), room.told("heard", "final")
        assert texts[0] == "h"
        assert texts[-1] == "hello"
        assert final == ["false"] * (len(final) - 1) + ["true"]
        last = await room.ask("hearing", "last_heard")
        assert last["text"] == "hello"
        assert last["timestamp"].startswith("2027-01-15T08:00:01")

    async def test_speech_that_a_grammar_does_not_have_is_an_empty_text_and_no_recognised_speech(
        self, room: Room
    ) -> None:
        await room.subscribe("hearing", "heard")
        await room.subscribe("speech_recognizer", "speech_recognized")
        await room.say(np.concatenate([SILENCE, VOICE, SILENCE]))
        room.recognizer.understands = (OTHER_SPEECH,)
        room.events.clear()
        await room.say(np.concatenate([VOICE, SILENCE]))
        assert {each.event_type for each in room.events} == {"heard"}
        assert (room.told("heard", "text")[-1], room.told("heard", "final")[-1]) == ("", "true")
        assert (await room.ask("hearing", "last_heard"))["text"] == "hello"

    async def test_only_subscribed_events_are_announced(self, room: Room) -> None:
        await room.subscribe("hearing", "heard")
        await room.do("hearing", "stop")
        await room.subscribe("speech_recognizer", "speech_input_started")
        await room.say(np.concatenate([SILENCE, VOICE, SILENCE]))
        assert {event.event_type for event in room.events} == {"speech_input_started"}
        assert (await room.ask("hearing", "last_heard"))["text"] == "hello"
        await room.do("speech_recognizer", "stop")
        await room.say(np.concatenate([VOICE, SILENCE]))
        assert len(room.events) == 1


async def test_speech_is_detected_for_a_voice_that_attends(room: Room) -> None:
    began: list[float] = []
    room.senses.speech.speech_began.add(began.append)
    leave = room.senses.speech.attend()
    await room.say(np.concatenate([SILENCE, VOICE, SILENCE]))
    assert began == [pytest.approx(1000.8, abs=0.1)]
    assert room.recognizer.opened == 0
    leave()
