"""The simulated robot's components keep the contract of every component."""

from collections.abc import Awaitable, Callable, Mapping
from typing import ClassVar
from unittest.mock import patch

from openrois_robots.simulated.adapter import simulated_robot
from openrois_robots.simulated.simulation import SimulationSettings

from openrois.component.component import Component
from openrois.contract import Client
from openrois.testing import ComponentContract
from openrois.testing.subject import LocalSubject
from openrois.types.streams import HolderNotification
from tests.support.simulated_robot import scripted_synthesizer
from tests.support.streaming import VirtualClock


class _OfTheRobot(ComponentContract):
    """The contract of a component of a robot that an application holds, which lives as long as a rule is tried."""

    __test__ = False
    name: ClassVar[str]

    async def try_rule(self, rule: Callable[[LocalSubject], Awaitable[None]]) -> None:
        with patch("openrois_body.speech_options.VoiceChoice.make", scripted_synthesizer):
            async with simulated_robot("robot", SimulationSettings(), VirtualClock()) as self._robot:
                told = HolderNotification(component_ref="robot/teleoperation", holds=True, epoch=1)
                self._robot.operator_control.apply_holder(told, Client("1", lambda _method, _params: None))
                await super().try_rule(rule)

    async def component(self) -> Component:
        return next(each for each in self._robot.components if each.name == self.name)


class TestSystemInformation(_OfTheRobot):
    __test__, name = True, "system_info"


class TestNavigation(_OfTheRobot):
    __test__, name = True, "navigation"
    parameters: Mapping[str, str] = {"target_positions": '["-3,-1","reader"]'}


class TestMove(_OfTheRobot):
    __test__, name = True, "move"
    parameters: Mapping[str, str] = {"line": "[500,90]"}


class TestFollow(_OfTheRobot):
    __test__, name = True, "follower"
    parameters: Mapping[str, str] = {"target_object_ref": "reader", "distance": "500"}


class TestGaze(_OfTheRobot):
    __test__, name = True, "gaze"


class TestTeleoperation(_OfTheRobot):
    __test__, name = True, "teleoperation"


class TestSpeechSynthesis(_OfTheRobot):
    __test__, name = True, "speech_synthesizer"
    parameters: Mapping[str, str] = {"speech_text": "Hello"}


class TestSpeechStream(_OfTheRobot):
    __test__, name = True, "speech_stream"


class TestDialogue(_OfTheRobot):
    __test__, name = True, "dialogue"


class TestSurroundings(_OfTheRobot):
    __test__, name = True, "surroundings"


class TestDock(_OfTheRobot):
    __test__, name = True, "dock"


class TestPersonDetection(_OfTheRobot):
    __test__, name = True, "person_detecter"


class TestPersonLocalization(_OfTheRobot):
    __test__, name = True, "person_localizer"
    parameters: Mapping[str, str] = {"detection_threshold": "50", "minimum_interval": "100"}


async def test_every_component_is_tried() -> None:
    tried = {each.name for each in _OfTheRobot.__subclasses__()}
    async with simulated_robot("robot", SimulationSettings(), VirtualClock()) as robot:
        assert {component.name for component in robot.components} == tried
