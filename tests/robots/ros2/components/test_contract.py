"""The components of a robot that speaks ROS 2 keep the contract of every component."""

from collections.abc import Awaitable, Callable, Mapping
from typing import ClassVar

import pytest

from openrois.component.component import Component
from openrois.contract import Client
from openrois.testing import ComponentContract
from openrois.testing.subject import LocalSubject
from openrois.types.streams import HolderNotification
from tests.support.ros_robot import staged

pytestmark = pytest.mark.extra(name="ros2")


class _OfTheRobot(ComponentContract):
    """The contract of a component of a robot that an application holds, which lives as long as a rule is tried."""

    __test__ = False
    name: ClassVar[str]

    async def try_rule(self, rule: Callable[[LocalSubject], Awaitable[None]]) -> None:
        async with staged() as self._stage:
            self._stage.tell_battery(0.8)
            told = HolderNotification(component_ref="robot/teleoperation", holds=True, epoch=1)
            self._stage.robot.operator_control.apply_holder(told, Client("1", lambda _method, _params: None))
            await super().try_rule(rule)

    async def component(self) -> Component:
        component: Component = self._stage.component(self.name)
        return component


class TestSystemInformation(_OfTheRobot):
    __test__, name = True, "system_info"


class TestNavigation(_OfTheRobot):
    __test__, name = True, "navigation"
    parameters: Mapping[str, str] = {"target_positions": '["-3,-1","table"]'}


class TestMove(_OfTheRobot):
    __test__, name = True, "move"
    parameters: Mapping[str, str] = {"line": "[500,90]"}


class TestFollow(_OfTheRobot):
    __test__, name = True, "follower"
    parameters: Mapping[str, str] = {"target_object_ref": "visitor", "distance": "500"}


class TestTeleoperation(_OfTheRobot):
    __test__, name = True, "teleoperation"


class TestSpeechSynthesis(_OfTheRobot):
    __test__, name = True, "speech_synthesizer"
    parameters: Mapping[str, str] = {"speech_text": "Hello"}


async def test_every_component_is_tried() -> None:
    tried = {each.name for each in _OfTheRobot.__subclasses__()}
    async with staged() as stage:
        assert {component.name for component in stage.robot.components} == tried
