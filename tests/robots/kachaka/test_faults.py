"""A robot that hangs, dies, comes back, or was never there: what runs ends with ERROR, and works again by itself."""

import asyncio
import random
import time
from typing import Any

import grpc
import pytest
from openrois_robots.adapter.link import PATIENCE, PERIOD
from openrois_robots.kachaka.adapter import linked_kachaka
from openrois_robots.kachaka.api.address import Address
from openrois_robots.kachaka.options import KachakaSettings
from openrois_robots.kachaka.simulator.servicer import SimulatorServicer
from openrois_streaming.clock import SystemClock

from openrois.client import Client, Fault
from openrois.client.components import Move, Navigation, SpeechSynthesis, SystemInformation
from openrois.errors import ComponentFailed
from openrois.testing import harness
from openrois.types.codes import ErrorType
from tests.support.kachaka import linked, simulated, simulator_process
from tests.support.robots import ended, until


async def navigate(client: Client, *targets: str) -> None:
    navigation = await client.find(Navigation)
    async with navigation.bound():
        await navigation.set(target_positions=list(targets))
        await client.run(navigation.start())


async def turn(client: Client) -> None:
    move = await client.find(Move)
    async with move.bound():
        await move.set(line=[0, 1])
        await client.run(move.start())


async def test_a_frozen_robot_ends_commands_and_is_back_by_itself() -> None:
    async with (
        simulator_process() as home,
        linked(home.address) as robot,
        harness(*robot.components) as client,
    ):
        going = asyncio.ensure_future(navigate(client, "kitchen"))
        speech = await client.find(SpeechSynthesis)
        async with speech.bound():
            await speech.set(speech_text="something long " * 30)
            speaking = asyncio.ensure_future(client.run(speech.start()))
            await until(lambda: robot.commands.figures.begun == 2)
            frozen_at = time.monotonic()
            home.freeze()
            failures = [await ended(each) for each in (going, speaking)]
        print(f"both commands ended {time.monotonic() - frozen_at:.2f} s after the robot was frozen")
        for failure in failures:
            assert isinstance(failure, ComponentFailed)
            assert f"the Kachaka at {home.address.text} has not answered for 1 s" in str(failure) or (
                "was not answered within" in str(failure)
            )
        with pytest.raises(ComponentFailed, match=r"navigation does not work now \(ERROR\): the Kachaka at"):
            await navigate(client, "kitchen")
        home.thaw()
        await until(lambda: robot.state.link.is_up)
        await until(lambda: robot.commands.figures.cancelled == 2)
        await turn(client)


def test_a_frozen_robot_is_noticed_within_two_seconds() -> None:
    assert PERIOD + PATIENCE <= 1.5, "what waits ends when the link does"


async def test_a_robot_that_is_restarted_in_the_middle_ends_the_command_and_works_on() -> None:
    async with (
        simulator_process() as home,
        linked(home.address) as robot,
        harness(*robot.components) as client,
    ):
        going = asyncio.ensure_future(navigate(client, "kitchen"))
        await until(lambda: robot.commands.figures.begun)
        await home.kill()
        await home.start_again()
        failure = await ended(going)
        assert isinstance(failure, ComponentFailed)
        await until(lambda: robot.state.link.is_up)
        await turn(client)


async def test_applications_that_hold_a_component_are_told_of_a_lost_robot() -> None:
    async with (
        simulator_process() as home,
        linked(home.address) as robot,
        harness(*robot.components) as client,
    ):
        navigation = await client.find(Navigation)
        async with navigation.bound(), client.notices() as notices:
            await home.kill()
            fault = await anext(
                each
                async for each in notices
                if isinstance(each, Fault) and each.error_type is ErrorType.COMPONENT_NOT_RESPONDING
            )
            told = {each.name: each.value for each in await client.get_error_detail(fault.error_id)}
            assert any("cannot be reached: nothing listens at this port" in text for text in told.values()), told


async def test_of_several_calls_that_fail_the_same_one_is_told_each_time() -> None:
    class Stranger(SimulatorServicer):
        """What answers is no Kachaka."""

        async def _unknown(self, _request: Any, _context: Any) -> Any:
            self.count("asked")
            await asyncio.sleep(random.random() * 0.01)
            await _context.abort(grpc.StatusCode.UNIMPLEMENTED, "")

        GetRobotPose = GetBatteryInfo = GetError = IsReady = _unknown

    async with (
        simulated(servicer=Stranger) as (servicer, address),
        linked_kachaka("robot", KachakaSettings(address), SystemClock()) as robot,
    ):
        told = set()
        for asked in (1, 5, 9, 13):
            await until(lambda asked=asked: servicer.calls.get("asked", 0) > asked)  # type: ignore[misc]
            await until(lambda: "has no Get" in robot.state.link.problem)
            told.add(robot.state.link.problem)
        assert told == {
            f"the Kachaka at {address.text} cannot be reached: the robot has no GetRobotPose:"
            " its software may be too old, or what answers is no Kachaka"
        }


@pytest.mark.parametrize("address", [Address("127.0.0.1", 1)])
async def test_a_robot_that_is_not_there_is_uninitialized_with_a_reason(address: Address) -> None:
    async with (
        linked_kachaka("robot", KachakaSettings(address), SystemClock()) as robot,
        harness(*robot.components) as client,
    ):
        await until(lambda: "nothing listens" in robot.state.link.problem)
        assert {each.status.value for each in robot.components if each.name not in _ALWAYS} <= {
            "UNINITIALIZED",
            "ERROR",
        }
        sentence = (
            "the Kachaka at 127.0.0.1:1 cannot be reached: nothing listens at this port;"
            " check --robot, and that the Kachaka API is switched on in the robot's app"
        )
        assert all(each.problem() == sentence for each in robot.components if each.name not in _ALWAYS)
        with pytest.raises(ComponentFailed, match="is not connected yet \\(UNINITIALIZED\\): the Kachaka at"):
            await turn(client)
        information = await client.find(SystemInformation)
        assert (await information.query("health"))["health"] == sentence
        assert (await information.engine_status()).status.value == "UNINITIALIZED"
        with pytest.raises(ComponentFailed, match="nothing listens at this port"):
            await information.robot_position()


_ALWAYS = {"system_info"}
"""Components that work without a robot: they say what is wrong."""
