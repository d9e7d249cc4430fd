"""The contract suite on components that keep it, here and behind a gateway."""

from typing import Annotated

import pytest
from pydantic import Field

from openrois.adapter import command
from openrois.component.component import Component
from openrois.engine.registry import LocalRegistry
from openrois.testing import ComponentContract, findings, memory_gateway
from openrois.testing.contract import LOCAL_RULES, RULES, LocalRule
from tests.support.basics import BASICS
from tests.support.components import Bell, Lamp
from tests.support.fleet import everything

pytestmark = pytest.mark.extra(name="base")

NEEDS = {"speech_text": "hello"}


class TestLamp(ComponentContract):
    async def component(self) -> Lamp:
        return Lamp()


class Heater(Component, authority="Example", function="actuation"):
    """What a command takes has limits, which its profile does not tell."""

    @command
    async def heat(self, until: Annotated[float, Field(ge=5, le=30)]) -> float:
        return until


class TestHeater(ComponentContract):
    async def component(self) -> Heater:
        return Heater("heater")


class TestBell(ComponentContract):
    async def component(self) -> Bell:
        return Bell("other")


@pytest.mark.parametrize("rule", [*RULES, *LOCAL_RULES], ids=lambda rule: rule.__name__)
@pytest.mark.parametrize("kind", BASICS)
async def test_each_basic_component(kind: type[Component], rule: LocalRule) -> None:
    class Contract(ComponentContract):
        parameters = NEEDS if kind.__name__ == "SpeechSynthesis" else {}

        async def component(self) -> Component:
            return kind()

    await Contract().try_rule(rule)


def test_every_rule_is_a_test_of_its_own() -> None:
    tests = {name for name in dir(ComponentContract) if name.startswith("test_")}
    assert len(tests) == len(RULES) + len(LOCAL_RULES) == 19


async def test_a_contract_without_component_names_what_is_missing() -> None:
    with pytest.raises(NotImplementedError, match="async def component"):
        await ComponentContract().try_rule(RULES[0])


async def test_a_whole_adapter_behind_a_gateway() -> None:
    async with memory_gateway(*(kind() for kind in BASICS)) as gateway:
        assert await findings(gateway.engine, parameters={"robot/speech_synthesizer": NEEDS}) == []


@pytest.mark.parametrize("given", ["parameters", "refuses"])
async def test_what_is_said_of_a_component_that_is_not_there_is_refused(given: str) -> None:
    async with memory_gateway(*(kind() for kind in BASICS)) as gateway:
        with pytest.raises(ValueError, match=f"^{given} names 'robot/speech', which is not there: there are robot/"):
            await findings(gateway.engine, **{given: {"robot/speech": NEEDS}})  # type: ignore[arg-type]


async def test_a_robot_of_another_maker() -> None:
    assert await findings(everything().registry) == []


async def test_nothing_is_nothing_to_find() -> None:
    assert await findings(LocalRegistry("robot", [])) == []
