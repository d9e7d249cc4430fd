"""The link to a robot: signs of life, and the end of what waits."""

import asyncio
import gc
import logging
from collections.abc import AsyncIterator
from typing import Any

import pytest
from openrois_robots.adapter.link import PATIENCE, PERIOD, Linked, RobotLink, report_losses

from openrois.adapter import ComponentFailed, ComponentStatus
from openrois.aio.tasks import TaskScope
from openrois.component.authoring.marks import command
from openrois.component.component import Component
from openrois.types.codes import ErrorType
from tests.support.streaming import VirtualClock, settle

pytestmark = pytest.mark.extra(name="robot")


class Robot:
    """A robot that answers, refuses or hangs."""

    def __init__(self) -> None:
        self.error: Exception | None = OSError("connection refused")
        self.answers = asyncio.Event()
        self.answers.set()
        self.asked = 0

    async def probe(self) -> None:
        self.asked += 1
        await self.answers.wait()
        if self.error is not None:
            raise self.error


@pytest.fixture
async def robot() -> Robot:
    return Robot()


@pytest.fixture
async def clock() -> VirtualClock:
    return VirtualClock()


@pytest.fixture
async def link(robot: Robot, clock: VirtualClock) -> AsyncIterator[RobotLink]:
    made = RobotLink("the robot at 192.0.2.7:26400", robot.probe, clock)
    async with TaskScope() as tasks:
        tasks.start(made.run())
        yield made


async def linked(robot: Robot, clock: VirtualClock) -> None:
    robot.error = None
    await clock.advance(PERIOD)


async def test_it_is_uninitialized_until_the_robot_answers(robot: Robot, clock: VirtualClock, link: RobotLink) -> None:
    never_asked = RobotLink(link.robot, robot.probe, clock)
    assert never_asked.status is ComponentStatus.UNINITIALIZED
    assert never_asked.problem == "the robot at 192.0.2.7:26400 has not answered yet"
    await settle()
    assert link.status is ComponentStatus.UNINITIALIZED
    assert link.problem == "the robot at 192.0.2.7:26400 cannot be reached: connection refused"
    robot.error = None
    await clock.advance(PERIOD)
    assert (link.is_up, link.status, link.problem) == (True, ComponentStatus.READY, "")


async def test_a_robot_that_hangs_is_lost_and_comes_back(robot: Robot, clock: VirtualClock, link: RobotLink) -> None:
    changes: list[bool] = []
    link.changed.add(lambda: changes.append(link.is_up))
    await linked(robot, clock)
    robot.answers.clear()
    await clock.advance(PERIOD + PATIENCE)
    assert link.status is ComponentStatus.ERROR
    assert link.problem == "the robot at 192.0.2.7:26400 has not answered for 1 s"
    robot.answers.set()
    await clock.advance(PERIOD)
    assert (link.status, link.problem) == (ComponentStatus.READY, "")
    assert changes == [True, False, True]


async def test_a_robot_that_tells_what_the_adapter_does_not_understand_is_lost_and_asked_again(
    robot: Robot, clock: VirtualClock, link: RobotLink, caplog: pytest.LogCaptureFixture
) -> None:
    await linked(robot, clock)
    robot.error = ValueError("cannot convert float NaN to integer")
    for _ in range(5):
        await clock.advance(PERIOD)
    assert [record.exc_info is not None for record in caplog.records if record.levelno >= logging.WARNING] == [
        *(False, True, False)
    ], "it could not be reached; what it tells, with where that fails, once; that it is lost"
    assert link.status is ComponentStatus.ERROR
    assert link.problem == (
        "the robot at 192.0.2.7:26400 tells what this adapter does not understand:"
        " ValueError: cannot convert float NaN to integer"
    )
    robot.error = None
    await clock.advance(PERIOD)
    assert link.is_up


async def test_each_change_is_logged_once(
    robot: Robot, clock: VirtualClock, link: RobotLink, caplog: pytest.LogCaptureFixture
) -> None:
    robot.error = ComponentFailed("asleep")
    await clock.advance(2 * PERIOD)
    caplog.set_level(logging.INFO)
    caplog.clear()
    robot.error = ComponentFailed("its battery is empty")
    await clock.advance(10 * PERIOD)
    robot.error = None
    await clock.advance(10 * PERIOD)
    assert robot.asked >= 20
    assert [record.getMessage() for record in caplog.records] == [
        "the robot at 192.0.2.7:26400 cannot be reached: its battery is empty",
        "the robot at 192.0.2.7:26400 is linked",
    ]


async def test_what_waits_for_a_robot_ends_when_it_is_lost(robot: Robot, clock: VirtualClock, link: RobotLink) -> None:
    ended: list[str] = []

    async def moving() -> None:
        try:
            await asyncio.Event().wait()
        finally:
            ended.append("moving")

    await linked(robot, clock)
    waiting = asyncio.ensure_future(link.during(moving()))
    await settle()
    robot.answers.clear()
    await clock.advance(PERIOD + PATIENCE)
    with pytest.raises(ComponentFailed, match="has not answered for 1 s"):
        await waiting
    assert ended == ["moving"]


async def test_work_ends_as_it_ends_while_the_robot_is_there(
    robot: Robot, clock: VirtualClock, link: RobotLink
) -> None:
    async def work(fails: bool) -> str:
        if fails:
            raise ComponentFailed("a wheel is stuck")
        return "done"

    await linked(robot, clock)
    assert await link.during(work(fails=False)) == "done"
    with pytest.raises(ComponentFailed, match="a wheel is stuck"):
        await link.during(work(fails=True))


async def test_work_that_is_cancelled_is_ended(robot: Robot, clock: VirtualClock, link: RobotLink) -> None:
    await linked(robot, clock)
    ended = asyncio.Event()

    async def moving() -> None:
        try:
            await asyncio.Event().wait()
        finally:
            ended.set()

    waiting = asyncio.ensure_future(link.during(moving()))
    await settle()
    waiting.cancel()
    with pytest.raises(asyncio.CancelledError):
        await waiting
    assert ended.is_set()


async def test_work_that_fails_while_it_is_ended_is_no_complaint_of_the_loop(
    robot: Robot, clock: VirtualClock, link: RobotLink
) -> None:
    complaints: list[dict[str, Any]] = []
    asyncio.get_running_loop().set_exception_handler(lambda _loop, context: complaints.append(context))
    ended = asyncio.Event()

    async def moving() -> None:
        try:
            await ended.wait()
        finally:
            raise ComponentFailed("it was stopped at the robot")

    await linked(robot, clock)
    for is_over in (False, True):
        waiting = asyncio.ensure_future(link.during(moving()))
        await settle()
        if is_over:
            ended.set()
            await asyncio.sleep(0)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
    del waiting
    gc.collect()
    assert complaints == []


async def test_nothing_begins_without_a_robot(link: RobotLink) -> None:
    async def work() -> None:
        pytest.fail("it began")

    await settle()
    with pytest.raises(ComponentFailed, match="cannot be reached: connection refused"):
        await link.during(work())


class Arm(Linked, Component, authority="Example", function="actuation"):
    """A component of a robot."""

    @command
    async def start(self) -> None: ...


async def test_its_components_say_why_they_do_not_work(robot: Robot, clock: VirtualClock, link: RobotLink) -> None:
    arm, told = Arm(link), list[tuple[ErrorType, str]]()
    await arm.bring_up()
    arm.report = lambda kind, sentence: told.append((kind, sentence))
    report_losses(link, [arm])
    with pytest.raises(ComponentFailed, match=r"^arm is not connected yet \(UNINITIALIZED\): the robot at .*$"):
        await arm.run("start", ())
    await linked(robot, clock)
    await arm.run("start", ())
    robot.error = OSError("connection refused")
    await clock.advance(PERIOD)
    with pytest.raises(ComponentFailed, match=r"^arm does not work now \(ERROR\): .*: connection refused$"):
        await arm.run("start", ())
    assert told == [(ErrorType.COMPONENT_NOT_RESPONDING, link.problem)]
