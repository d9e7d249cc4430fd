"""Connections, robots and gateways that go away and come back, as applications in C# see that."""

import asyncio
import random
import signal
from contextlib import AsyncExitStack
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from openrois.adapter.running import serve
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.testing import FaultRelay
from tests.sdk_csharp.conftest import Start
from tests.sdk_csharp.test_operations import attached
from tests.support.components import Lamp
from tests.support.demo import free_port
from tests.support.deployment import adapter, gateway
from tests.support.fleet import everything
from tests.support.ground import gateway_program
from tests.support.json_program import JsonProgram
from tests.support.seeds import SOME

pytestmark = pytest.mark.timeout(120)


async def comes_back(app: JsonProgram) -> list[tuple[str, object]]:
    """Return what the application says until its binding and subscription are restored."""
    said: list[tuple[str, object]] = []
    while [about for about, _ in said].count("restored") < 2:
        said.append(await app.says_something())
    assert ("restored", ["binding"]) in said
    assert ("restored", ["subscription"]) in said
    return said


async def test_bindings_and_subscriptions_are_restored(start: Start) -> None:
    robot = everything()
    async with AsyncExitStack() as stack:
        async with gateway() as running:
            async with attached(running, robot):
                app = await stack.enter_async_context(start("keeper", running.url))
                await app.says("ready")
                await app.go_on()
                assert await app.says("reached") == "place 0"
            # The engine is gone: both are lost, which is reported once.
            lost = [await app.says("lost"), await app.says("lost")]
            assert sorted(lost) == [["binding", "UnsupportedException"], ["subscription", "UnsupportedException"]]
            async with attached(running, robot):
                await comes_back(app)
                await app.go_on()
                assert await app.says("reached") == "place 1"
            await app.says("lost")
            await app.says("lost")
        # The gateway is gone, too. The robot's name for its component is all that another one has in common with it.
        port = urlsplit(running.url).port
        assert port is not None
        async with run_gateway(GatewaySettings(port=port)) as another, attached(another, robot):
            said = await comes_back(app)
            assert ("connected", None) in said
            await app.go_on()
            assert await app.says("reached") == "place 2"
            await app.go_on()
            await app.ends()


async def test_after_a_crash_of_the_gateway_each_command_has_its_end(start: Start, tmp_path: Path) -> None:
    port = str(free_port())
    url = f"http://127.0.0.1:{port}/"
    options = ("--port", port, "--journal", str(tmp_path / "journal"))
    async with AsyncExitStack() as stack:
        async with gateway_program(*options, log=tmp_path / "log") as running:
            await stack.enter_async_context(serve(Lamp(), engine_id="robot", gateway=url))
            app = await stack.enter_async_context(start("survivor", url))
            await app.says("ready")
            running.signal(signal.SIGKILL)
            await running.ended()
        async with gateway_program(*options, log=tmp_path / "log"):
            restarted = ["ComponentFailedException", "the gateway was restarted"]
            assert await app.says("ended") == [restarted, restarted]
            await app.ends()


async def test_a_cut_connection_is_resumed_with_what_was_bound_and_runs(start: Start) -> None:
    lamp = Lamp()
    async with (
        gateway() as running,
        adapter(running, lamp),
        FaultRelay(running.url) as relay,
        start("resumer", relay.url) as app,
    ):
        await app.says("ready")
        relay.cut()
        await app.go_on()
        said = [await app.says_something() for _ in range(5)]
        states = [what for about, what in said if about == "state"]
        assert states == ["Waiting", "Connecting", "Connected"]
        assert [each for each in said if each[0] != "state"] == [("lease", "Mine"), ("running", True)]
        lamp.may_end.set()
        await app.go_on()
        assert await app.says("ended") == "Ok"
        await app.ends()


async def test_what_does_not_come_is_given_up(start: Start) -> None:
    async with gateway() as running, AsyncExitStack() as stack:
        from tests.support.deployment import Robot, application

        robot = Robot()
        await stack.enter_async_context(adapter(running, *robot.parts()))
        other = await stack.enter_async_context(application(running))
        app = await stack.enter_async_context(start("impatient", running.url))
        await app.says("ready")
        assert await other.code("rois.command.bind", component_ref="robot/lamp") == "OK"
        robot.door.may_answer.clear()
        await app.go_on()
        assert await app.says("body") == "TaskCanceledException"
        await app.says("opening")
        assert await app.says("wait") == "TaskCanceledException"
        robot.door.may_answer.set()
        await app.go_on()
        assert await app.says("opened") == "Ok"
        robot.door.may_answer.clear()
        robot.door.asked.clear()
        await app.says("asking")
        async with asyncio.timeout(20):
            await robot.door.asked.wait()
        await app.go_on()
        assert await app.says("query") == "TaskCanceledException"
        assert await app.says("before") == "TaskCanceledException"
        robot.door.may_answer.set()
        await app.ends()


@pytest.mark.parametrize("seed", SOME)
async def test_calls_that_are_under_way_when_a_connection_is_cut_end_and_leave_nothing(start: Start, seed: int) -> None:
    chance = random.Random(seed)
    async with (
        gateway() as running,
        attached(running, everything()),
        FaultRelay(running.url) as relay,
        start("restless", relay.url, SEED=str(seed)) as app,
    ):
        await app.says("ready")
        for _ in range(6):
            for _ in range(chance.randrange(1, 5)):
                await app.says("many")
            relay.cut()
        await app.go_on()
        while (said := await app.says_something()) == ("many", None):
            pass
        assert said == ("free", [True])
        # Of what moves a robot the end is not known; a body was lost; the rest is repeated.
        known = {"nothing", "TaskCanceledException", "ConnectionLostException", "OutOfResourcesException"}
        assert set(await app.says("ended")) <= known
        assert await app.says("failures") == []
        await app.ends()
