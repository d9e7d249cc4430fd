"""What the senses of the camera tell of what is seen, and that each keeps the contract of every component."""

import asyncio
import json
from collections.abc import Mapping
from urllib.parse import unquote

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.camera_senses import camera_senses
from openrois_body.components.enrolment import LOOKS, Enrolment
from openrois_body.vision.analysis import Analysis
from openrois_body.vision.cascades import CascadeFinder
from openrois_body.vision.gallery import MAX_ENROLLED, Gallery
from openrois_body.vision.head_reader import HeadReader
from openrois_body.vision.patterns import PatternRecognizer
from openrois_body.vision.sighting import Refs
from openrois_body.vision.watch import Watch
from openrois_media.devices import Camera
from openrois_streaming.source.source import RawVideo
from pydantic import ValidationError

from openrois.component.component import Component
from openrois.engine.registry import LocalRegistry
from openrois.errors import BadParameter, ComponentFailed, OutOfResources
from openrois.testing import ComponentContract
from openrois.types.messages import Argument
from tests.support.camera import CameraStage, seen_person
from tests.support.streaming import FedSource, VirtualClock, settle

PERSON, FACE = "urn:x-rois:def:person:OpenRoIS::avatar", "urn:x-rois:def:face:OpenRoIS::avatar"
NOD, TILT, SHAKE = (f"urn:x-rois:def:gesture:OMG::{number}" for number in (1, 2, 3))
LOOK = np.ones(3, np.float32)
EVENTS = (
    ("person_detecter", "person_detected"),
    ("person_localizer", "person_localized"),
    ("person_identifier", "person_identified"),
    ("face_detecter", "face_detected"),
    ("face_localizer", "face_localized"),
    ("gesture_recognizer", "gesture_recognized"),
    ("sight", "seen"),
)


@pytest.fixture
async def stage() -> CameraStage:
    return CameraStage()


async def test_numbers_are_told_when_they_change(stage: CameraStage) -> None:
    await stage.listen("person_detecter", "person_detected")
    away = seen_person(2, face=False)
    assert stage.see() == []
    assert stage.see(seen_person(1)) == [{"number": 1}]
    assert stage.see(seen_person(1)) == []
    assert stage.see(seen_person(1), away) == [{"number": 2}]
    await stage.listen("face_detecter", "face_detected")
    assert stage.see(seen_person(1), away) == [{"number": 1}]
    assert stage.see(away) == [{"number": 1}, {"number": 0}]
    assert stage.see() == [{"number": 0}]


async def test_the_moment_is_that_of_the_picture(stage: CameraStage) -> None:
    said: list[str] = []
    await stage.registry.subscribe("avatar/face_detecter", "face_detected", lambda item: said.append(str(item)))
    stage.see(seen_person())
    assert "2027-01-15T08:00:00.1" in said[0]


@pytest.mark.parametrize(("component", "event"), EVENTS)
async def test_later_subscriber_gets_the_present_state(stage: CameraStage, component: str, event: str) -> None:
    ann = seen_person(name="Ann", gesture=NOD)
    first = await stage.listen(component, event)
    (told,) = stage.see(ann)
    await stage.registry.unsubscribe(first)
    assert stage.see(ann) == []
    await stage.listen(component, event)
    assert stage.see(ann) == [told]


@pytest.mark.parametrize(("component", "event"), EVENTS)
async def test_pictures_are_decoded_only_while_there_is_a_subscription(
    stage: CameraStage, component: str, event: str
) -> None:
    source: FedSource[RawVideo] = FedSource()
    stage.camera.inlet.plug("s", source)
    running = asyncio.ensure_future(stage.senses.run())
    await settle()
    assert not source.is_open
    subscription = await stage.listen(component, event)
    await settle()
    assert source.is_open
    await stage.registry.unsubscribe(subscription)
    await settle()
    assert not source.is_open
    running.cancel()
    await asyncio.wait({running})


@pytest.mark.parametrize(("pause", "go_on"), [("suspend", "resume"), ("stop", "start")])
async def test_stopped_sense_announces_nothing_while_others_are_active(
    stage: CameraStage, pause: str, go_on: str
) -> None:
    await stage.listen("person_detecter", "person_detected")
    await stage.listen("face_detecter", "face_detected")
    await stage.registry.invoke("avatar/person_detecter", pause)
    away = seen_person(2, face=False)
    assert stage.see(seen_person(1), away) == [{"number": 1}]
    await stage.registry.invoke("avatar/person_detecter", go_on)
    assert stage.see(seen_person(1), away) == [{"number": 2}]


@pytest.mark.parametrize(("pause", "go_on"), [("suspend", "resume"), ("stop", "start")])
@pytest.mark.parametrize(
    ("component", "event"), [("person_detecter", "person_detected"), ("face_detecter", "face_detected")]
)
async def test_departure_during_inactivity_is_announced(
    stage: CameraStage, component: str, event: str, pause: str, go_on: str
) -> None:
    await stage.listen(component, event)
    assert len(stage.see(seen_person())) == 1
    await stage.registry.invoke(f"avatar/{component}", pause)
    assert stage.see() == []
    await stage.registry.invoke(f"avatar/{component}", go_on)
    assert [*stage.see(), *stage.see()] == [{"number": 0}]


@pytest.mark.parametrize(
    ("component", "event", "ref", "kind"),
    [
        ("person_localizer", "person_localized", "person_ref", PERSON),
        ("face_localizer", "face_localized", "face_ref", FACE),
    ],
)
async def test_places_are_told_as_the_parameters_say(
    stage: CameraStage, component: str, event: str, ref: str, kind: str
) -> None:
    await stage.set(component, detection_threshold="100", minimum_interval="500")
    await stage.listen(component, event)
    both = stage.see(seen_person(1), seen_person(2, x=0.5))
    assert both == [
        {ref: [f"{kind}/camera/1", f"{kind}/camera/2"], "position_data": ["0.000,1.000,0.0000", "0.500,1.000,0.0000"]}
    ]
    assert stage.see(seen_person(1, x=0.05), seen_person(2, x=0.5), passed=1.0) == []
    assert stage.see(seen_person(1, x=0.15), seen_person(2, x=0.5), passed=1.0) != []
    assert stage.see(seen_person(1, x=0.3), seen_person(2, x=0.5)) == []
    assert stage.see(seen_person(1, x=0.3), seen_person(2, x=0.5), passed=0.5) != []
    turned = stage.see(seen_person(1, x=0.3), seen_person(2, x=0.5, face=False), passed=0.5)
    assert bool(turned) == (component == "face_localizer")


async def test_recognised_person_is_announced_on_arrival(stage: CameraStage) -> None:
    await stage.listen("person_identifier", "person_identified")
    ann, ben = seen_person(1, name="Ann"), seen_person(2, name="Ben B.")
    assert stage.see(seen_person(1)) == []
    assert stage.see(ann) == [{"person_ref": [f"{PERSON}/enrolled/Ann"]}]
    assert stage.see(ann) == []
    assert stage.see(ann, ben) == [{"person_ref": [f"{PERSON}/enrolled/Ann", f"{PERSON}/enrolled/Ben%20B."]}]
    assert stage.see(ben) == []
    assert stage.see(ann, ben) != []


async def test_gestures_are_told_by_their_numbers_in_annex_d(stage: CameraStage) -> None:
    (told,) = (
        json.loads(each.value)
        for each in await stage.registry.query("avatar/gesture_recognizer", "get_parameter")
        if each.name == "recognizable_gestures"
    )
    assert told == [NOD, TILT, SHAKE]
    await stage.listen("gesture_recognizer", "gesture_recognized")
    assert stage.see(seen_person()) == []
    assert stage.see(seen_person(1, gesture=NOD), seen_person(2, gesture=TILT)) == [{"gesture_ref": [NOD, TILT]}]


async def test_sight_is_what_can_be_drawn_over_the_picture(stage: CameraStage) -> None:
    await stage.listen("sight", "seen")
    assert stage.see() == []
    assert stage.see(seen_person(1, name="Ann", gesture=SHAKE), seen_person(2), seen_person(3, face=False)) == [
        {
            "person_ref": [f"{PERSON}/camera/1", f"{PERSON}/camera/2"],
            "box": ["0.4000,0.3000,0.2000,0.3000"] * 2,
            "name": ["Ann", ""],
            "gesture_ref": [SHAKE, ""],
        }
    ]
    nothing: dict[str, list[str]] = {"person_ref": [], "box": [], "name": [], "gesture_ref": []}
    assert [stage.see(seen_person(3, face=False)), stage.see()] == [[nothing], []]


async def test_sense_without_a_working_finder_reports_an_error(stage: CameraStage) -> None:
    stage.senses.watch.failure = "install something"
    for component in stage.senses.components:
        assert component.status == "ERROR"


class TestEnrolment:
    async def enrol(self, stage: CameraStage, name: str) -> str:
        argument = Argument(name="name", data_type_ref="string", value=name)
        (result,) = await stage.registry.invoke("avatar/enrolment", "enrol", (argument,))
        assert result.name == "person_ref"
        return result.value

    async def forget(self, stage: CameraStage, name: str) -> None:
        argument = Argument(name="name", data_type_ref="string", value=name)
        await stage.registry.invoke("avatar/enrolment", "forget", (argument,))

    async def names(self, stage: CameraStage) -> list[str]:
        (result,) = await stage.registry.query("avatar/enrolment", "enrolled")
        found: list[str] = json.loads(result.value)
        return found

    @pytest.fixture
    async def stage(self) -> CameraStage:
        stage = CameraStage()
        source: FedSource[RawVideo] = FedSource()
        stage.camera.inlet.plug("s", source)
        return stage

    async def test_person_is_enrolled_and_forgotten(self, stage: CameraStage) -> None:
        enrolling = asyncio.ensure_future(self.enrol(stage, "Ann"))
        await settle()
        with pytest.raises(ComponentFailed, match="another enrolment is running"):
            await self.enrol(stage, "Ben")
        for _ in range(LOOKS - 1):
            stage.see(seen_person(1, likeness=LOOK))
        stage.see(seen_person(1), passed=0.1)
        # A second face, and another one alone, begin anew.
        stage.see(seen_person(1, likeness=LOOK), seen_person(2, likeness=LOOK))
        for _ in range(LOOKS - 1):
            stage.see(seen_person(2, likeness=LOOK))
        await settle()
        assert not enrolling.done()
        for _ in range(3):
            stage.see(seen_person(2, likeness=LOOK))
        assert await enrolling == f"{PERSON}/enrolled/Ann"
        assert await self.names(stage) == ["Ann"]
        await self.forget(stage, "Ann")
        assert await self.names(stage) == []
        with pytest.raises(BadParameter, match="no person is enrolled as 'Ann'"):
            await self.forget(stage, "Ann")

    @pytest.mark.parametrize("name", ["", "x" * 65, "a\nb"])
    async def test_a_name_that_is_none_is_refused(self, stage: CameraStage, name: str) -> None:
        with pytest.raises(BadParameter):
            await self.enrol(stage, name)

    @given(st.text(st.characters(), max_size=70))
    def test_whatever_is_said_is_a_name_that_comes_back_or_is_refused(self, name: str) -> None:
        async def converse() -> None:
            stage = CameraStage()
            stage.camera.inlet.plug("s", FedSource[RawVideo]())
            enrolling = asyncio.ensure_future(self.enrol(stage, name))
            await settle()
            for _ in range(LOOKS):
                stage.see(seen_person(1, likeness=LOOK))
            try:
                ref = await enrolling
            except (BadParameter, ValidationError):
                # The second is what the wire says to text that is none.
                assert not name or len(name) > 64 or not name.isprintable()
                assert await self.names(stage) == []
                return
            assert ref.isascii()
            assert ref.count("/") == 2
            assert unquote(ref.removeprefix(f"{PERSON}/enrolled/")) == name
            assert await self.names(stage) == [name]
            await self.forget(stage, name)
            assert await self.names(stage) == []

        asyncio.run(converse())

    async def test_enrolment_fails_without_a_camera(self, stage: CameraStage) -> None:
        stage.camera.inlet.unplug("s")
        with pytest.raises(ComponentFailed, match="no camera"):
            await self.enrol(stage, "Ann")

    @pytest.mark.parametrize(("faces", "trouble"), [(0, "no face"), (1, "come nearer"), (2, "2 faces")])
    async def test_failed_enrolment_says_why(self, faces: int, trouble: str) -> None:
        clock, camera, gallery = VirtualClock(), Camera(), Gallery()
        camera.inlet.plug("s", FedSource())
        watch = Watch(camera, clock, Analysis(CascadeFinder(), PatternRecognizer(), HeadReader(), gallery))
        component = Enrolment(watch, camera, gallery, Refs("avatar"), patience=0.05)
        enrolling = asyncio.ensure_future(component.enrol("Ann"))
        await settle()
        stage = CameraStage()
        stage.senses.watch.seen.add(watch.seen.notify_all)
        stage.see(*(seen_person(number) for number in range(faces)))
        with pytest.raises(ComponentFailed, match=trouble):
            await enrolling
        assert gallery.names == ()

    async def test_the_gallery_is_full_some_time(self) -> None:
        camera, gallery = Camera(), Gallery()
        camera.inlet.plug("s", FedSource())
        for number in range(MAX_ENROLLED):
            gallery.enrol(str(number), [LOOK])
        watch = Watch(camera, VirtualClock(), Analysis(CascadeFinder(), PatternRecognizer(), HeadReader(), gallery))
        component = Enrolment(watch, camera, gallery, Refs("avatar"))
        with pytest.raises(OutOfResources):
            await component.enrol("one more")


class _OfTheCamera(ComponentContract):
    async def component(self) -> Component:
        senses = camera_senses("avatar", Camera(), VirtualClock()).components
        name = type(self).__name__.removeprefix("Test").removesuffix("Contract")
        return next(each for each in senses if each.component_type.code == name)


class TestPersonDetectionContract(_OfTheCamera):
    pass


class TestPersonLocalizationContract(_OfTheCamera):
    parameters: Mapping[str, str] = {"detection_threshold": "50"}


class TestPersonIdentificationContract(_OfTheCamera):
    pass


class TestFaceDetectionContract(_OfTheCamera):
    pass


class TestFaceLocalizationContract(_OfTheCamera):
    parameters: Mapping[str, str] = {"minimum_interval": "200"}


class TestGestureRecognitionContract(_OfTheCamera):
    pass


class TestSightContract(_OfTheCamera):
    pass


class TestEnrolmentContract(_OfTheCamera):
    pass


async def test_all_of_them_are_in_one_engine() -> None:
    registry = LocalRegistry("avatar", camera_senses("avatar", Camera(), VirtualClock()).components)
    assert len((await registry.discover()).component_profiles) == 8
