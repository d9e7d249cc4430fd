"""The Kachaka's components keep the contract of every component."""

from collections.abc import Awaitable, Callable, Mapping
from typing import ClassVar

from openrois_robots.kachaka.simulator.house import Pose

from openrois.component.component import Component
from openrois.contract import Client
from openrois.testing import ComponentContract
from openrois.testing.subject import LocalSubject
from openrois.types.streams import HolderNotification
from tests.support.kachaka import linked, simulated


class _OfTheRobot(ComponentContract):
    """The contract of a component of a robot that an application holds, which lives as long as a rule is tried."""

    __test__ = False
    name: ClassVar[str]

    async def try_rule(self, rule: Callable[[LocalSubject], Awaitable[None]]) -> None:
        async with simulated(1.0, at=Pose(1.0, 0.0)) as (_, address), linked(address) as self._robot:
            told = HolderNotification(component_ref="robot/teleoperation", holds=True, epoch=1)
            self._robot.operator_control.apply_holder(told, Client("1", lambda _method, _params: None))
            await super().try_rule(rule)

    async def component(self) -> Component:
        return next(each for each in self._robot.components if each.name == self.name)


class TestSystemInformation(_OfTheRobot):
    __test__, name = True, "system_info"


class TestNavigation(_OfTheRobot):
    __test__, name = True, "navigation"
    parameters: Mapping[str, str] = {"target_positions": '["kitchen","1,1"]'}


class TestMove(_OfTheRobot):
    __test__, name = True, "move"
    parameters: Mapping[str, str] = {"line": "[500,90]"}


class TestTeleoperation(_OfTheRobot):
    __test__, name = True, "teleoperation"


class TestSpeechSynthesis(_OfTheRobot):
    __test__, name = True, "speech_synthesizer"
    parameters: Mapping[str, str] = {"speech_text": "Hello, I am a Kachaka", "volume": "70"}


class TestReaction(_OfTheRobot):
    __test__, name = True, "reaction"
    parameters: Mapping[str, str] = {"reaction_ref": "urn:x-rois:def:reaction:OpenRoIS::kachaka/front_light"}


class TestDock(_OfTheRobot):
    __test__, name = True, "dock"


class TestShelves(_OfTheRobot):
    __test__, name = True, "shelves"


class TestEmergencyStop(_OfTheRobot):
    __test__, name = True, "emergency_stop"


class TestMap(_OfTheRobot):
    __test__, name = True, "map"


class TestSurroundings(_OfTheRobot):
    __test__, name = True, "surroundings"


class TestPersonDetection(_OfTheRobot):
    __test__, name = True, "person_detecter"


class TestPersonLocalization(_OfTheRobot):
    __test__, name = True, "person_localizer"
    parameters: Mapping[str, str] = {"detection_threshold": "50", "minimum_interval": "100"}


class TestPersonIdentification(_OfTheRobot):
    __test__, name = True, "person_identifier"


class TestFaceDetection(_OfTheRobot):
    __test__, name = True, "face_detecter"


class TestFaceLocalization(_OfTheRobot):
    __test__, name = True, "face_localizer"
    parameters: Mapping[str, str] = {"detection_threshold": "50", "minimum_interval": "100"}


class TestGestureRecognition(_OfTheRobot):
    __test__, name = True, "gesture_recognizer"


class TestEnrolment(_OfTheRobot):
    __test__, name = True, "enrolment"


async def test_every_component_is_tried() -> None:
    tried = {each.name for each in _OfTheRobot.__subclasses__()}
    async with simulated() as (_, address), linked(address) as robot:
        assert {component.name for component in robot.components} == tried
