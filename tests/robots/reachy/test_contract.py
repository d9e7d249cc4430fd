"""The Reachy Mini's components keep the contract of every component."""

from collections.abc import Awaitable, Callable, Mapping
from typing import ClassVar
from unittest.mock import patch

import pytest

from openrois.component.component import Component
from openrois.testing import ComponentContract
from openrois.testing.subject import LocalSubject
from openrois.types.codes import ComponentStatus
from tests.support.reachy import linked, scripted_synthesizer, simulated
from tests.support.robots import until

pytestmark = pytest.mark.extra(name="reachy")


class _OfTheRobot(ComponentContract):
    """The contract of a component of a robot, which lives as long as a rule is tried."""

    __test__ = False
    name: ClassVar[str]

    async def try_rule(self, rule: Callable[[LocalSubject], Awaitable[None]]) -> None:
        with patch("openrois_body.speech_options.VoiceChoice.make", scripted_synthesizer):
            async with (
                simulated(has_media=True, sound_from=1.0) as (_, address),
                linked(address) as self._robot,
            ):
                await until(lambda: all(each.status is ComponentStatus.READY for each in self._robot.components))
                await super().try_rule(rule)

    async def component(self) -> Component:
        return next(each for each in self._robot.components if each.name == self.name)


class TestSystemInformation(_OfTheRobot):
    __test__, name = True, "system_info"


class TestReaction(_OfTheRobot):
    __test__, name = True, "reaction"
    parameters: Mapping[str, str] = {"reaction_ref": "urn:x-rois:def:reaction:OMG::1"}


class TestMove(_OfTheRobot):
    __test__, name = True, "move"
    parameters: Mapping[str, str] = {"line": "[0,10]"}


class TestSpeechSynthesis(_OfTheRobot):
    __test__, name = True, "speech_synthesizer"
    parameters: Mapping[str, str] = {"speech_text": "Hello"}


class TestDialogue(_OfTheRobot):
    __test__, name = True, "dialogue"


class TestSoundLocalization(_OfTheRobot):
    __test__, name = True, "sound_localizer"
    parameters: Mapping[str, str] = {"detection_threshold": "50", "minimum_interval": "100"}


class TestGaze(_OfTheRobot):
    __test__, name = True, "gaze"


async def test_every_component_is_tried() -> None:
    tried = {each.name for each in _OfTheRobot.__subclasses__()}
    async with simulated() as (_, address), linked(address) as robot:
        assert {component.name for component in robot.components} == tried
