"""Driving by hand: velocities while an operator drives, and standing when he does not."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, cast

import pytest
from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_body.teleoperation.steering import STANDING, Velocity
from openrois_robots.adapter.link import RobotLink
from openrois_robots.kachaka.api.calls import KachakaApi, RobotSilent
from openrois_robots.kachaka.api.error_texts import ErrorTexts
from openrois_robots.kachaka.driver import HOLD, Driver
from openrois_robots.kachaka.limits import DrivingLimits

from openrois.adapter import ComponentFailed
from openrois.aio.tasks import TaskScope
from tests.support.streaming import VirtualClock, settle

AHEAD = Velocity(0.15, 0.0, 0.785)


@dataclass
class Wheels:
    """An API that notes what it is told, and when; it can refuse, and be silent."""

    clock: VirtualClock
    told: list[tuple[float, str]] = field(default_factory=list)
    refuses: set[str] = field(default_factory=set)
    silent: int = 0

    async def call(self, method: str, request: Any, *, deadline: float = 1.0) -> Any:
        if self.silent:
            self.silent -= 1
            raise RobotSilent(f"{method} was not answered")
        if method == "SetManualControlEnabled":
            what = f"manual {request.enable}"
        else:
            what = f"{request.linear:.2f} {request.angular:.2f}"
        self.told.append((round(self.clock.now(), 3), what))
        result = pb2.Result(success=method not in self.refuses, error_code=7 if method in self.refuses else 0)
        kind = pb2.SetManualControlEnabledResponse if "Manual" in method else pb2.SetRobotVelocityResponse
        return kind(result=result)

    @property
    def words(self) -> list[str]:
        return [what for _, what in self.told]


@dataclass
class Seat:
    """A driver of wheels."""

    driver: Driver
    wheels: Wheels
    clock: VirtualClock
    link: RobotLink
    ended: list[str]

    async def run(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            await self.clock.advance(0.05)
            await settle()


@asynccontextmanager
async def seated(limits: DrivingLimits | None = None) -> AsyncIterator[Seat]:
    clock = VirtualClock()
    wheels = Wheels(clock)
    api = cast("KachakaApi", wheels)

    async def alive() -> None:
        if lost:
            raise OSError("gone")

    lost: list[bool] = []
    link = RobotLink("the robot", alive, clock)
    driver = Driver(api, link, ErrorTexts(api), limits or DrivingLimits(), clock)
    ended: list[str] = []

    async def end_motion(reason: str) -> None:
        ended.append(reason)

    driver.end_motion = end_motion
    async with TaskScope() as tasks:
        tasks.start(link.run())
        tasks.start(driver.run())
        await settle()
        yield Seat(driver, wheels, clock, link, ended)


async def test_it_sends_normalised_velocities_ten_times_a_second_after_manual_control() -> None:
    async with seated() as seat:
        seat.driver.drive(AHEAD)
        await seat.run(0.3)
        assert seat.wheels.words[:4] == ["manual True", "0.50 0.50", "0.50 0.50", "0.50 0.50"]
        assert seat.ended == ["an operator drives the robot by hand"]
        times = [at for at, what in seat.wheels.told if what == "0.50 0.50"]
        assert times[1] - times[0] == pytest.approx(0.1)


async def test_without_the_next_velocity_it_stands_after_half_a_second() -> None:
    async with seated() as seat:
        began = seat.clock.now()
        seat.driver.drive(AHEAD)
        await seat.run(1.0)
        at, what = seat.wheels.told[-1]
        assert what == "0.00 0.00"
        assert at - began <= HOLD + 0.1
        assert not seat.driver.is_driving


async def test_a_halt_reaches_the_robot_with_the_next_message() -> None:
    async with seated() as seat:
        seat.driver.drive(AHEAD)
        await seat.run(0.2)
        before = len(seat.wheels.told)
        seat.driver.halt("the dead man's switch")
        await settle()
        assert seat.wheels.words[before:] == ["0.00 0.00"], "one message, at once: no time passes"


async def test_limits_hold_whatever_is_asked_for() -> None:
    async with seated(DrivingLimits(speed=0.15, turn=0.785)) as seat:
        seat.driver.drive(Velocity(-5.0, 1.0, 9.0))
        await seat.run(0.05)
        assert seat.wheels.words[1] == "-0.50 0.50"


async def test_a_refusal_is_told_with_the_next_velocity() -> None:
    async with seated() as seat:
        seat.wheels.refuses.add("SetManualControlEnabled")
        seat.driver.drive(AHEAD)
        await seat.run(0.1)
        with pytest.raises(ComponentFailed, match=r"the robot did not begin manual control: error 7"):
            seat.driver.drive(AHEAD)
        seat.wheels.refuses.clear()
        seat.driver.drive(AHEAD)
        await seat.run(0.1)
        assert "0.50 0.50" in seat.wheels.words
        assert seat.driver.figures.failed == 1


async def test_standing_is_tried_again_where_it_was_not_taken() -> None:
    async with seated() as seat:
        seat.driver.drive(AHEAD)
        await seat.run(0.1)
        seat.wheels.silent = 2
        seat.driver.halt("released")
        await settle()
        assert seat.wheels.words[-1] == "0.00 0.00"
        assert seat.driver.figures.failed == 2


async def test_a_lost_robot_is_not_driven() -> None:
    async with seated() as seat:
        seat.link._judge("the robot is gone")
        with pytest.raises(ComponentFailed, match="the robot is gone"):
            seat.driver.drive(AHEAD)
        assert seat.wheels.told == []


async def test_commands_get_the_robot_when_it_stands_and_not_before() -> None:
    async with seated() as seat:
        await seat.driver.release()
        assert seat.wheels.told == [], "there is no manual control to end"
        seat.driver.drive(AHEAD)
        await seat.run(0.1)
        with pytest.raises(ComponentFailed, match="an operator drives the robot by hand"):
            await seat.driver.release()
        seat.driver.halt("released")
        await seat.driver.release()
        assert seat.wheels.words[-2:] == ["0.00 0.00", "manual False"]


async def test_at_its_end_the_robot_stands_and_manual_control_is_off() -> None:
    async with seated() as seat:
        seat.driver.drive(AHEAD)
        await seat.run(0.1)
        wheels = seat.wheels
    assert wheels.words[-2:] == ["0.00 0.00", "manual False"]


async def test_gaze_and_other_input_have_no_effect() -> None:
    async with seated() as seat:
        seat.driver.turn_eyes(1.0, 1.0)
        seat.driver.pass_on({"kind": "key"})
        seat.driver.halt("nothing moves")
        await asyncio.sleep(0)
        await seat.run(0.2)
        assert seat.wheels.told == []
        assert seat.driver._velocity == STANDING
