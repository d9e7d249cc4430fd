"""Tests of the lamp: without a server, a port or a lamp."""

import pytest
from lamp_adapter import Lamp

from openrois.client import BadParameter
from openrois.testing import ComponentContract, harness


async def test_the_lamp_says_that_it_was_switched() -> None:
    async with harness(Lamp("lamp")) as client:
        lamp = client.component("robot/lamp")
        async with lamp.bound(), lamp.event("switched") as switched:
            await lamp.command("switch", on=True)
            assert await anext(aiter(switched)) == {"on": True}


async def test_it_does_not_take_words_for_a_switch() -> None:
    async with harness(Lamp("lamp")) as client:
        lamp = client.component("robot/lamp")
        async with lamp.bound():
            with pytest.raises(BadParameter):
                await lamp.command("switch", on="perhaps")


class TestLamp(ComponentContract):
    """What holds for every component, tried on this one."""

    async def component(self) -> Lamp:
        return Lamp("lamp")
