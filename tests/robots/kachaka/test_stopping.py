"""STOP, a released component and an operator's silence reach the robot's own stop; how soon is printed."""

import asyncio
import json
import time
from collections.abc import Callable
from contextlib import AsyncExitStack

import pytest
from openrois_body.teleoperation.pilot import PATIENCE
from openrois_robots.adapter import link
from openrois_robots.kachaka.api import commands
from openrois_robots.kachaka.api.calls import KachakaApi

from openrois.client import Client
from openrois.client.components import Move, Navigation
from openrois.commands import stop
from openrois.contract import Client as Application
from openrois.errors import OutOfResources
from openrois.types.streams import HolderNotification
from tests.support.kachaka import Linked, staged
from tests.support.kachaka_home import home
from tests.support.robots import PATIENCE as LONGEST
from tests.support.robots import ended, until
from tests.support.teleoperation import Hand


async def driving(stage: Linked) -> "asyncio.Task[None]":
    """Let the robot drive to its kitchen."""

    async def go() -> None:
        navigation = await stage.client.find(Navigation)
        async with navigation.bound():
            await navigation.set(target_positions=["kitchen"])
            await stage.client.run(navigation.start())

    going = asyncio.create_task(go())
    await until(lambda: stage.simulation.jobs and stage.simulation.jobs[0].has_begun)
    return going


def told(what: str, stage: Linked, began: float) -> None:
    """Print how soon the robot was stopped; its clock is this machine's."""
    print(f"{what}: the robot's own stop {1000 * (stage.simulation.stops[-1] - began):.0f} ms later")


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let STOP and its calls to the robot take as long as they need: on a busy machine they may be over a second.

    What becomes of a STOP that is not confirmed within its second is tested in `tests/openrois/commands/test_stop.py`.
    """
    monkeypatch.setattr(stop, "STOP_TIMEOUT", LONGEST)
    monkeypatch.setattr(link, "PATIENCE", LONGEST)
    monkeypatch.setattr(commands, "_CANCELLING", LONGEST)
    monkeypatch.setattr(KachakaApi.call, "__kwdefaults__", {"deadline": LONGEST})


@pytest.mark.usefixtures("patient")
async def test_stop_is_one_cancellation_at_the_robot() -> None:
    async with staged(1.0) as stage:
        going = await driving(stage)
        began = time.monotonic()
        await stage.client.control.stop_all()
        assert len(stage.simulation.stops) == 1, "it has stopped when STOP is answered"
        told("STOP", stage, began)
        await ended(going)
        assert not stage.simulation.jobs


@pytest.mark.parametrize("ends_by", ["releasing it", "leaving"])
async def test_an_application_that_lets_go_leaves_a_robot_that_stands(ends_by: str) -> None:
    async with home() as house, AsyncExitStack() as stack:
        client = await stack.enter_async_context(Client(house.url))
        navigation = await client.find(Navigation)
        await navigation.bind()
        await navigation.set(target_positions=["kitchen"])
        going = asyncio.ensure_future(client.run(navigation.start()))
        robot = house.servicer.robot
        await until(lambda: robot.jobs and robot.jobs[0].has_begun)
        began = time.monotonic()
        if ends_by == "leaving":
            await client.close()
        else:
            await navigation.release()
        await until(lambda: robot.stops)
        print(f"{ends_by}: the robot's own stop {1000 * (robot.stops[-1] - began):.0f} ms later")
        assert not robot.jobs
        going.cancel()
        await ended(going)


async def test_of_two_commands_that_move_the_robot_the_later_one_does_and_the_other_is_told_why() -> None:
    async with home() as house, Client(house.url) as one, Client(house.url) as other:
        navigation, move = await one.find(Navigation), await one.find(Move)
        await navigation.bind()
        # Both are its legs, which no other application moves meanwhile.
        with pytest.raises(OutOfResources, match="same part"):
            await (await other.find(Move)).bind()
        await navigation.set(target_positions=["kitchen"])
        going = asyncio.ensure_future(one.run(navigation.start()))
        robot = house.servicer.robot
        await until(lambda: robot.jobs and robot.jobs[0].has_begun)
        async with move.bound():
            await move.set(line=[50, 0])
            await one.run(move.start())
        assert str(await ended(going)).endswith("ended ABORT: move has begun to go 50 mm")


class Operator:
    """An application that operates the robot by hand."""

    def __init__(self, stage: Linked) -> None:
        self.stage = stage
        self.application = Application("1", lambda _method, _params: None)
        self.told: list[str] = []
        control = stage.robot.operator_control
        notification = HolderNotification(component_ref="robot/teleoperation", holds=True, epoch=1)
        control.apply_holder(notification, self.application)
        self.sink = control.input_sink(self.application, self.told.append)
        self.hand = Hand()

    async def drive(self, enough: Callable[[], object]) -> None:
        """Hold the key for ahead, ten times a second as a page does, until it is enough."""
        while not enough():
            self.sink.input_came("input", json.dumps(self.hand.state().to_json()))
            await asyncio.sleep(0.1)


async def operate(client: Client) -> None:
    teleoperation = client.component("robot/teleoperation")
    async with teleoperation.bound():
        await teleoperation.command("start")


async def test_an_operator_drives_and_silence_stops_the_robot() -> None:
    async with staged(1.0) as stage:
        operator = Operator(stage)
        operating = asyncio.create_task(operate(stage.client))
        await operator.drive(lambda: stage.simulation.body.pose.x > 0.1)
        assert not stage.simulation.stops
        silent_since = time.monotonic()
        await until(lambda: stage.simulation.stops)
        told(f"no input (of which {1000 * PATIENCE:.0f} ms are patience)", stage, silent_since)
        stage.robot.operator_control.forget_client(operator.application)
        assert "the application that operated is gone" in str(await ended(operating))
        assert stage.simulation.manual.velocity(stage.simulation.now) == (0.0, 0.0)


async def test_an_operator_who_leaves_stops_the_robot() -> None:
    async with staged(1.0) as stage:
        operator = Operator(stage)
        operating = asyncio.create_task(operate(stage.client))
        await operator.drive(lambda: stage.simulation.body.pose.x > 0.05)
        began = time.monotonic()
        stage.robot.operator_control.forget_client(operator.application)
        await until(lambda: stage.simulation.stops)
        told("the operator has left", stage, began)
        await ended(operating)


async def test_driving_by_hand_comes_before_a_motion_and_is_over_before_the_next_one() -> None:
    async with staged(1.0) as stage:
        going = await driving(stage)
        operator = Operator(stage)
        operating = asyncio.create_task(operate(stage.client))
        await operator.drive(lambda: stage.simulation.manual.sent > 2)
        assert "an operator drives the robot by hand" in str(await ended(going))
        await until(lambda: stage.simulation.stops and not stage.robot.driver.is_driving)
        stage.robot.operator_control.forget_client(operator.application)
        await ended(operating)
        again = await driving(stage)
        again.cancel()
        await ended(again)
