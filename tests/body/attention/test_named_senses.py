"""Each event of a sense names its visitor, and none tells of what the visitor does not consent to be recognised."""

import asyncio
import itertools
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.attention.attention import Attention
from openrois_body.camera_senses import camera_senses
from openrois_body.components.enrolment import LOOKS, Enrolment
from openrois_body.components.operator import Operator
from openrois_body.components.visitors import Visitors
from openrois_body.microphone_senses import microphone_senses
from openrois_body.vision.sighting import Sighting
from openrois_media.devices import Camera, Microphone
from openrois_media.visitors.registry import VisitorRegistry
from openrois_streaming.clock import wall_at
from openrois_streaming.source.loudness import SILENCE as SILENT
from openrois_streaming.source.source import RawAudio

from openrois.component.component import Component
from openrois.contract import Event
from openrois.engine.registry import LocalRegistry
from openrois.errors import ComponentFailed
from openrois.types.codes import Purpose
from tests.media.visitors.test_visitor import Sender
from tests.support.camera import seen_person
from tests.support.hearing import stereo_48k, voice
from tests.support.listening import ScriptedRecognizer
from tests.support.streaming import VirtualClock, settle

SILENCE = np.zeros((36_000, 2), np.int16)
VOICE = stereo_48k(voice(1.0))
UTTERANCE = np.concatenate([SILENCE, VOICE, SILENCE])


class Room:
    """The senses of a body with visitors, and what applications are told."""

    def __init__(
        self, recognizer: ScriptedRecognizer | None = None, may_send: Callable[[], bool] | None = None
    ) -> None:
        self.clock = VirtualClock()
        self.visitors = VisitorRegistry("avatar", self.clock)
        self.microphone, self.camera = Microphone(self.clock, self.visitors), Camera(self.visitors)
        self.attention = Attention(self.visitors, self.microphone, self.camera, self.clock)
        self.recognizer = recognizer or ScriptedRecognizer()
        self.ears = microphone_senses(
            "avatar", self.microphone, self.clock, self.recognizer, may_send, visitors=self.visitors
        )
        self.eyes = camera_senses("avatar", self.camera, self.clock)
        senses = (*self.ears.components, *self.eyes.components)
        operator = self.operator = Operator(self.microphone, self.camera)
        component = Visitors("avatar", self.visitors, self.attention, senses)
        self.registry = LocalRegistry("avatar", (*senses, operator, component))
        self.told: list[tuple[str, dict[str, str]]] = []

    async def subscribe(self, **components: str) -> None:
        for event, component in components.items():
            await self.registry.subscribe(f"avatar/{component}", event, self._note)

    def _note(self, item: object) -> None:
        assert isinstance(item, Event)
        self.told.append((item.event_type, {result.name: result.value for result in item.results}))

    def names(self) -> list[str]:
        return [name for name, _ in self.told]

    async def say(self, sender: Sender, sound: NDArray[np.int16]) -> None:
        """Let a visitor be heard."""
        for start in range(0, len(sound), 480):
            await sender.source.feed(RawAudio(sound[start : start + 480], self.clock.now()))
            await self.clock.advance(0.01)


@pytest.fixture
async def room() -> AsyncIterator[Room]:
    room = Room()
    running = [asyncio.ensure_future(work) for work in (room.microphone.listen(), room.ears.run())]
    await settle()
    yield room
    for task in running:
        task.cancel()
    await asyncio.wait(running)


async def test_what_is_said_names_who_said_it(room: Room) -> None:
    await room.subscribe(speech_recognized="speech_recognizer", heard="hearing", sensed="visitors")
    ann = Sender(room.visitors)
    await settle()
    await room.say(ann, UTTERANCE)
    ref = ann.visitor.visitor_ref
    heard = [params["visitor_ref"] for name, params in room.told if name == "heard"]
    assert len(heard) > 1
    assert set(heard) == {ref}
    place = room.names().index("speech_recognized")
    assert room.told[place - 1] == (
        "sensed",
        {"visitor_ref": ref, "component_ref": "avatar/speech_recognizer", "event_type": "speech_recognized"},
    )


async def test_every_event_of_every_sense_names_its_visitor(room: Room) -> None:
    senses = [each for each in (*room.ears.components, *room.eyes.components, room.operator) if not _is_enrolment(each)]
    events = {(f"avatar/{each.name}", name) for each in senses for name in await _events_of(room, each.name)}
    told: list[Event] = []
    for component_ref, name in (("avatar/visitors", "sensed"), *events):
        await room.registry.subscribe(component_ref, name, told.append)  # type: ignore[arg-type]
    ann = Sender(room.visitors)
    ref = ann.visitor.visitor_ref
    await settle()
    # The right microphone is nearer, so the sound has a place, too.
    aside = np.column_stack([np.roll(VOICE[:, 0], 12), VOICE[:, 0]])
    noise = np.random.default_rng(3).normal(0, 10, aside.shape)
    await room.say(ann, np.concatenate([SILENCE, np.clip(aside + noise, -32_768, 32_767).astype(np.int16), SILENCE]))
    person = seen_person(name="ann", gesture="urn:nod")
    for seen in ((person,), ()):
        room.eyes.watch.seen.notify_all(Sighting(room.clock.now(), seen, ref))
    named: set[tuple[str, str]] = set()
    for before, event in itertools.pairwise(told):
        results = {each.name: each.value for each in event.results}
        announced = {each.name: each.value for each in before.results}
        if event.event_type != "sensed":
            named.add((event.component_ref, event.event_type))
            by_itself = results.get("visitor_ref")
            assert ref in (by_itself, announced.get("visitor_ref")), event
            if by_itself is None:
                assert announced["component_ref"] == event.component_ref
                assert announced["event_type"] == event.event_type
    assert named == events


def _is_enrolment(component: Component) -> bool:
    """Tell whether a component remembers faces, and announces none."""
    return isinstance(component, Enrolment)


async def _events_of(room: Room, name: str) -> list[str]:
    profile = (await room.registry.discover()).component_profiles[f"avatar/{name}"]
    return [each.name for each in profile.event_profiles]


async def test_after_a_withdrawal_senses_announce_the_end_of_what_lasted_and_nothing_else(room: Room) -> None:
    for name in ("sound_detecter", "sound_localizer", "speech_recognizer", "hearing", "operator"):
        for event in await _events_of(room, name):
            await room.subscribe(**{event: name})
    ann = Sender(room.visitors)
    await settle()
    await room.say(ann, np.concatenate([SILENCE, VOICE[:24_000]]))
    assert {"sound_detected", "speech_input_started"} <= set(room.names())
    room.told.clear()
    ann.consent()
    ends = {
        "sound_detected": {"number": "0"},
        "speech_input_finished": {},
        "microphone_level": {"rms": "-100.0", "peak": "-100.0"},
    }
    assert {name: {key: params[key] for key in ends[name]} for name, params in room.told} == ends
    room.told.clear()
    await room.say(ann, np.concatenate([VOICE[24_000:], SILENCE]))
    await room.clock.advance(2.0)
    assert room.told == []


async def test_what_is_said_before_another_is_attended_to_is_not_said_by_that_one(room: Room) -> None:
    await room.subscribe(sensed="visitors", speech_recognized="speech_recognizer")
    ann, bob = Sender(room.visitors), Sender(room.visitors, name="bob")
    room.attention.set_mode(ann.visitor.visitor_ref)
    await settle()
    await room.say(ann, np.concatenate([SILENCE, VOICE]))
    room.attention.set_mode(bob.visitor.visitor_ref)
    await settle()
    await room.say(bob, SILENCE)
    recognized = [params for _, params in room.told if params.get("event_type") == "speech_recognized"]
    assert [each["visitor_ref"] for each in recognized] == [ann.visitor.visitor_ref]
    await room.say(bob, UTTERANCE)
    recognized = [params for _, params in room.told if params.get("event_type") == "speech_recognized"]
    assert [each["visitor_ref"] for each in recognized] == [ann.visitor.visitor_ref, bob.visitor.visitor_ref]


@pytest.mark.parametrize("again", [False, True])
async def test_what_was_said_before_a_withdrawal_is_not_recognised_after_it(room: Room, again: bool) -> None:
    await room.subscribe(speech_recognized="speech_recognizer", heard="hearing")
    ann = Sender(room.visitors)
    await settle()
    # The recogniser answers late.
    room.recognizer.held = asyncio.Event()
    await room.say(ann, np.concatenate([SILENCE, VOICE]))
    ann.consent(Purpose.LIVE)
    if again:
        ann.consent(Purpose.LIVE, Purpose.RECOGNITION)
    room.recognizer.held.set()
    await room.say(ann, SILENCE)
    await room.clock.advance(2.0)
    assert room.told == []
    assert sum(room.recognizer.heard) == 0
    if again:
        await room.say(ann, UTTERANCE)
        assert "speech_recognized" in room.names()


@pytest.mark.parametrize("leaves", [False, True])
async def test_words_are_forgotten_with_the_consent_to_them(room: Room, leaves: bool) -> None:
    await room.subscribe(heard="hearing")
    ann, bob = Sender(room.visitors), Sender(room.visitors, name="bob")
    room.attention.set_mode(ann.visitor.visitor_ref)
    await settle()
    await room.say(ann, UTTERANCE)

    async def last_heard() -> str:
        return next(each.value for each in await room.registry.query("avatar/hearing", "last_heard"))

    assert await last_heard() == "hello"
    bob.consent()
    assert await last_heard() == "hello"
    if leaves:
        room.visitors.forget_client(ann.client)
    else:
        ann.consent(Purpose.LIVE)
    assert await last_heard() == ""


@pytest.mark.parametrize("seconds", [0.1, 0.25, 0.4])
async def test_attention_that_changes_within_a_word_mixes_no_voices(room: Room, seconds: float) -> None:
    await room.subscribe(speech_recognized="speech_recognizer")
    speech: list[tuple[str, int]] = []
    room.ears.speech.speech.add(
        lambda samples: speech.append((room.ears.speech.sender, int(np.abs(samples).max(initial=0))))
    )
    ann, bob = Sender(room.visitors), Sender(room.visitors, name="bob")
    loud, quiet = (stereo_48k(voice(2.0, amplitude=level)) for level in (16_000, 3_000))
    room.attention.set_mode(ann.visitor.visitor_ref)
    await settle()
    await room.say(ann, SILENCE)
    middle = round(seconds * 48_000)
    await room.say(ann, loud[:middle])
    room.attention.set_mode(bob.visitor.visitor_ref)
    await settle()
    await room.say(bob, np.concatenate([quiet[middle:], SILENCE]))
    heard = {sender: max(level for each, level in speech if each == sender) for sender, _ in speech}
    assert heard[bob.visitor.visitor_ref] < 4_000


async def test_speech_that_began_before_a_withdrawal_does_not_go_on_after_a_new_consent(room: Room) -> None:
    await room.subscribe(speech_input_started="speech_recognizer")
    ann = Sender(room.visitors)
    await settle()
    await room.say(ann, np.concatenate([SILENCE, VOICE[:4_800]]))
    assert room.told == []
    ann.consent(Purpose.LIVE)
    assert room.told == []
    ann.consent(Purpose.LIVE, Purpose.RECOGNITION)
    again = datetime.fromtimestamp(wall_at(room.clock, room.clock.now()), UTC)
    await room.say(ann, np.concatenate([VOICE[4_800:], SILENCE]))
    ((_, told),) = room.told
    assert datetime.fromisoformat(told["timestamp"]) >= again - timedelta(seconds=0.05)


async def test_the_level_is_silence_from_a_withdrawal_on(room: Room) -> None:
    await room.subscribe(microphone_level="operator")
    ann = Sender(room.visitors)
    await settle()
    await room.say(ann, VOICE[:14_400])
    assert float(room.told[-1][1]["rms"]) > -60
    room.told.clear()
    await room.say(ann, VOICE[14_400:19_200])
    ann.consent(Purpose.RECOGNITION)
    assert room.microphone.level == SILENT
    await room.say(ann, VOICE[19_200:])
    await room.clock.advance(1.0)
    assert [params["rms"] for _, params in room.told] == ["-100.0"]


async def test_no_level_is_of_two_visitors(room: Room) -> None:
    await room.subscribe(microphone_level="operator")
    ann, bob = Sender(room.visitors), Sender(room.visitors, name="bob")
    room.attention.set_mode(ann.visitor.visitor_ref)
    await settle()
    await room.say(ann, VOICE[:9_600])
    room.attention.set_mode(bob.visitor.visitor_ref)
    await settle()
    await room.say(bob, SILENCE[:24_000])
    levels = [(params["visitor_ref"], float(params["peak"])) for _, params in room.told]
    assert max((peak for ref, peak in levels if ref == bob.visitor.visitor_ref), default=-100.0) == -100.0


async def test_a_recogniser_elsewhere_gets_the_speech_of_those_alone_who_consent_to_that() -> None:
    allowed = [False]
    recognizer = ScriptedRecognizer()
    recognizer.destination = "https://h.example"
    room = Room(recognizer, lambda: allowed[-1])
    running = [asyncio.ensure_future(work) for work in (room.microphone.listen(), room.ears.run())]
    await room.subscribe(speech_recognized="speech_recognizer", speech_input_started="speech_recognizer")
    ann = Sender(room.visitors)
    await settle()
    # Neither the consent of the visitor is enough nor that of those who run the body: the stricter wins.
    ann.consent(Purpose.RECOGNITION, Purpose.TRANSFER)
    await room.say(ann, UTTERANCE)
    allowed.append(True)
    ann.consent(Purpose.RECOGNITION)
    await room.say(ann, UTTERANCE)
    assert set(room.names()) == {"speech_input_started"}
    assert room.recognizer.heard == []
    ann.consent(Purpose.RECOGNITION, Purpose.TRANSFER)
    await room.say(ann, UTTERANCE)
    assert room.names()[-1] == "speech_recognized"
    for task in running:
        task.cancel()
    await asyncio.wait(running)


async def test_a_withdrawal_in_the_middle_of_speech_keeps_all_of_it_from_a_recogniser_elsewhere() -> None:
    recognizer = ScriptedRecognizer()
    recognizer.destination = "https://h.example"
    room = Room(recognizer, lambda: True)
    failures: list[str] = []
    room.ears.recognition.failed.add(failures.append)
    running = [asyncio.ensure_future(work) for work in (room.microphone.listen(), room.ears.run())]
    await room.subscribe(speech_recognized="speech_recognizer")
    ann = Sender(room.visitors, frozenset({Purpose.RECOGNITION, Purpose.TRANSFER}))
    await settle()
    await room.say(ann, np.concatenate([SILENCE, VOICE]))
    ann.consent(Purpose.RECOGNITION)
    ann.consent(Purpose.RECOGNITION, Purpose.TRANSFER)
    await room.say(ann, np.concatenate([VOICE, SILENCE]))
    # A recogniser sends when the utterance ends, and this one was not ended.
    assert room.recognizer.heard == []
    assert room.names() == []
    await room.say(ann, UTTERANCE)
    assert room.names() == ["speech_recognized"]
    assert failures == []
    for task in running:
        task.cancel()
    await asyncio.wait(running)


async def test_who_is_not_to_be_recognised_is_heard_live_and_announced_by_no_sense(room: Room) -> None:
    await room.subscribe(
        sound_detected="sound_detecter", speech_input_started="speech_recognizer", microphone_level="operator"
    )
    ann = Sender(room.visitors, frozenset({Purpose.LIVE}))
    await settle()
    await room.say(ann, UTTERANCE)
    levels = [params for name, params in room.told if name == "microphone_level"]
    assert levels[0]["visitor_ref"] == ann.visitor.visitor_ref
    assert set(room.names()) == {"microphone_level"}


async def test_what_is_said_and_who_is_seen_is_in_no_log(room: Room, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    await room.subscribe(speech_recognized="speech_recognizer", heard="hearing", seen="sight")
    ann = Sender(room.visitors)
    await settle()
    await room.say(ann, UTTERANCE)
    named = Sighting(room.clock.now(), (seen_person(name="Annabella"),), ann.visitor.visitor_ref)
    room.eyes.watch.seen.notify_all(named)
    assert {"speech_recognized", "heard", "seen"} <= set(room.names())
    for word in (*room.recognizer.understands, "Annabella"):
        assert word not in caplog.text


async def test_a_face_is_kept_of_a_visitor_who_consents_to_that(room: Room) -> None:
    ann = Sender(room.visitors)
    room.visitors.add_stream(
        ann.client, "ann/camera", room.visitors.sink(ann.client, room.visitors.cameras, "video"), None
    )
    (enrolment,) = (each for each in room.eyes.components if isinstance(each, Enrolment))
    enrolment._patience = 0.1
    near = Sighting(room.clock.now(), (seen_person(likeness=np.zeros(4)),), ann.visitor.visitor_ref)

    async def enrol() -> str:
        enrolling = asyncio.ensure_future(enrolment.enrol("Ann"))
        await settle()
        for _ in range(LOOKS):
            room.eyes.watch.seen.notify_all(near)
        return await enrolling

    with pytest.raises(ComponentFailed, match="the visitor does not consent to be recorded"):
        await enrol()
    ann.consent(Purpose.RECOGNITION, Purpose.RECORDING)
    assert (await enrol()).endswith("enrolled/Ann")
    # Of one that states nothing it is kept as before there were statements.
    assert room.visitors.may_keep(Sender(room.visitors, None, "bob").visitor.visitor_ref)
    assert room.visitors.may_keep("")
    assert not room.visitors.may_keep("urn:gone")


def enrolment_of(room: Room) -> tuple[Enrolment, Callable[..., Awaitable[str]]]:
    """Return the enrolment, and what enrols the face that a visitor's camera shows."""
    (enrolment,) = (each for each in room.eyes.components if isinstance(each, Enrolment))
    enrolment._patience = 30.0

    async def enrol(name: str, ref: str, meanwhile: Callable[[], None] = lambda: None) -> str:
        near = Sighting(room.clock.now(), (seen_person(likeness=np.zeros(4)),), ref)
        enrolling = asyncio.ensure_future(enrolment.enrol(name))
        await settle()
        for _ in range(LOOKS):
            room.eyes.watch.seen.notify_all(near)
        meanwhile()
        return await enrolling

    return enrolment, enrol


KEPT_WITH = frozenset({Purpose.LIVE, Purpose.RECOGNITION, Purpose.RECORDING})


@pytest.mark.parametrize("lost", [Purpose.RECORDING, Purpose.RECOGNITION, None], ids=["recorded", "recognised", "left"])
async def test_a_face_is_forgotten_when_the_consent_that_it_rests_on_ends(room: Room, lost: Purpose | None) -> None:
    ann, bob = Sender(room.visitors), Sender(room.visitors, KEPT_WITH, "bob")
    room.visitors.add_stream(
        ann.client, "ann/camera", room.visitors.sink(ann.client, room.visitors.cameras, "video"), KEPT_WITH
    )
    ann_ref, bob_ref = ann.visitor.visitor_ref, bob.visitor.visitor_ref
    enrolment, enrol = enrolment_of(room)
    await enrol("Ann", ann_ref)
    await enrol("Anna", ann_ref)
    await enrol("Bob", bob_ref)
    # This is another person of the name by now, from the body's own camera.
    await enrol("Anna", "")
    ann.consent(Purpose.RECOGNITION, Purpose.RECORDING)
    assert await enrolment.enrolled() == ("Ann", "Anna", "Bob")
    if lost is None:
        room.visitors.forget_client(ann.client)
    else:
        ann.consent(*(purpose for purpose in KEPT_WITH if purpose is not lost))
    assert await enrolment.enrolled() == ("Anna", "Bob")


async def test_a_face_that_rests_on_no_statement_stays_when_one_is_made(room: Room) -> None:
    ann = Sender(room.visitors)
    room.visitors.add_stream(
        ann.client, "ann/camera", room.visitors.sink(ann.client, room.visitors.cameras, "video"), None
    )
    unstated = Sender(room.visitors, None, "operator")
    enrolment, enrol = enrolment_of(room)
    await enrol("Ann", unstated.visitor.visitor_ref)
    unstated.consent(Purpose.LIVE)
    room.visitors.forget_client(unstated.client)
    assert await enrolment.enrolled() == ("Ann",)


async def test_no_face_is_kept_of_a_visitor_who_withdraws_while_it_is_enrolled(room: Room) -> None:
    ann = Sender(room.visitors)
    room.visitors.add_stream(
        ann.client, "ann/camera", room.visitors.sink(ann.client, room.visitors.cameras, "video"), KEPT_WITH
    )
    enrolment, enrol = enrolment_of(room)
    with pytest.raises(ComponentFailed, match="the visitor does not consent to be recorded"):
        await enrol("Ann", ann.visitor.visitor_ref, lambda: ann.consent(Purpose.LIVE))
    assert await enrolment.enrolled() == ()


async def test_what_is_seen_names_whose_camera_it_is(room: Room) -> None:
    await room.subscribe(sensed="visitors", person_detected="person_detecter", seen="sight")
    ann = Sender(room.visitors)
    ref = ann.visitor.visitor_ref
    room.eyes.watch.seen.notify_all(Sighting(room.clock.now(), (seen_person(),), ref))
    assert room.names() == ["sensed", "person_detected", "sensed", "seen"]
    assert room.told[3][1]["visitor_ref"] == ref
    assert {params["visitor_ref"] for name, params in room.told if name == "sensed"} == {ref}
    room.told.clear()
    # The end of what was announced names no visitor that does not consent any more.
    ann.consent(Purpose.LIVE)
    room.eyes.watch.seen.notify_all(Sighting(room.clock.now(), (seen_person(), seen_person(2)), ref))
    assert room.names() == ["person_detected", "seen"]
    room.told.clear()
    # Without a picture there is no visitor to be told of.
    room.eyes.watch.seen.notify_all(Sighting(room.clock.now()))
    assert room.names() == ["person_detected", "seen"]
