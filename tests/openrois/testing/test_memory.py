"""The harness: components behind a gateway in memory, as an author of one tests them."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from openrois.adapter import Component, command
from openrois.client import Client
from openrois.client.components import Navigation
from openrois.errors import BadParameter, ComponentFailed, OutOfResources
from openrois.testing import harness, memory_gateway
from tests.support import basics
from tests.support.components import Bell, Lamp

pytestmark = pytest.mark.extra(name="base")


async def test_a_component_is_used_as_by_an_application() -> None:
    async with harness(Lamp(), engine_id="house") as client:
        lamp = client.component("house/lamp")
        async with lamp.bound():
            await lamp.set_parameter(colour="red")
            assert await lamp.command("switch", times=2) == {"total": 2}
        assert await lamp.get_parameter() == {"colour": "red", "level": 5}


@pytest.fixture
async def client() -> AsyncIterator[Client]:
    async with harness(Bell()) as client:
        yield client


async def test_it_may_be_a_fixture(client: Client) -> None:
    assert await client.component("robot/bell").query("component_status") == {"status": "READY"}


async def test_a_typed_proxy_finds_its_component() -> None:
    async with harness(basics.Navigation()) as client, asyncio.timeout(60):
        navigation = await client.find(Navigation)
        async with navigation.bound(), navigation.reached_target() as reached:
            await navigation.set(target_positions=("door", "lobby"))
            await navigation.start()
            told = [await anext(aiter(reached)), await anext(aiter(reached))]
        assert [(each.target, each.is_final_target) for each in told] == [("door", False), ("lobby", True)]


async def test_several_applications_at_one_gateway() -> None:
    async with memory_gateway(Lamp()) as gateway, gateway.client() as one, gateway.client() as other:
        async with one.component("robot/lamp").bound():
            with pytest.raises(OutOfResources):
                await other.bind("robot/lamp")
        await other.bind("robot/lamp")
        assert gateway.engine.directory.profile.engine_ids() == ("gateway", "robot")


async def test_components_are_connected_before_and_let_go_after() -> None:
    class Device(Component):
        def __init__(self, name: str, *, there: bool = True) -> None:
            super().__init__(name)
            self.there = there
            self.log: list[str] = []

        async def connect(self) -> None:
            self.log.append("connect")
            if not self.there:
                raise OSError("gone")

        async def disconnect(self) -> None:
            self.log.append("disconnect")

        @command
        async def start(self) -> None:
            self.log.append("start")

    good, bad = Device("good"), Device("bad", there=False)
    async with harness(good, bad) as client:
        await client.component("robot/good").command("start")
        with pytest.raises(ComponentFailed):
            await client.component("robot/bad").command("start")
        assert await client.component("robot/bad").query("component_status") == {"status": "ERROR"}
    assert good.log == ["connect", "start", "disconnect"]
    assert bad.log == ["connect"]


async def test_what_cannot_be_behind_a_gateway_is_a_mistake() -> None:
    for components, engine_id in (((Bell(), Bell()), "robot"), ((Bell(),), "a/b")):
        with pytest.raises(BadParameter):
            async with harness(*components, engine_id=engine_id):
                pass
    with pytest.raises(TimeoutError):
        async with harness(Bell(), engine_id="gateway", patience=0.1):
            pass


async def test_an_answer_that_does_not_come_is_not_waited_for() -> None:
    class Slow(basics.Reaction):
        async def available_reactions(self) -> tuple[str, ...]:
            await asyncio.Event().wait()
            return ()

    async with harness(Slow(), patience=1.0) as client:
        with pytest.raises(TimeoutError):
            await client.component("robot/reaction").query("available_reactions")
