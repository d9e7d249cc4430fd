"""Commands at the robot: matched by their ids, beside those of other programs, and ended with what they ended with."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import pytest
from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_robots.adapter.link import RobotLink
from openrois_robots.kachaka.api.address import Address
from openrois_robots.kachaka.api.calls import KachakaApi
from openrois_robots.kachaka.api.commands import Commands
from openrois_robots.kachaka.api.error_texts import ErrorTexts
from openrois_robots.kachaka.simulator.robot import RobotSettings
from openrois_robots.kachaka.simulator.servicer import SimulatorServicer
from openrois_streaming.clock import SystemClock

from openrois.adapter import ComponentFailed, OutOfResources
from openrois.aio.tasks import TaskScope
from openrois.errors import Aborted
from tests.support.kachaka import simulated, simulator_process
from tests.support.robots import ended, until

FAR = pb2.Command(move_forward_command=pb2.MoveForwardCommand(distance_meter=2.0, speed=0.3))
TURN = pb2.Command(rotate_in_place_command=pb2.RotateInPlaceCommand(angle_radian=0.01))
NOWHERE = pb2.Command(move_to_location_command=pb2.MoveToLocationCommand(target_location_id="L99"))
LOCK = pb2.Command(lock_command=pb2.LockCommand(duration_sec=3600))
SPEAK = pb2.Command(speak_command=pb2.SpeakCommand(text="Hello"))


@dataclass
class Adapter:
    """Commands of an adapter, and the link that they depend on."""

    commands: Commands
    link: RobotLink
    api: KachakaApi
    released: int = 0


@asynccontextmanager
async def adapter(address: Address) -> AsyncIterator[Adapter]:
    async with KachakaApi(address) as api, TaskScope() as tasks:
        clock = SystemClock()

        async def probe() -> None:
            await api.call("GetRobotPose")

        async def release() -> None:
            made.released += 1

        link = RobotLink("the robot", probe, clock)
        texts = ErrorTexts(api)
        made = Adapter(Commands(api, link, texts, clock, release), link, api)
        tasks.start(link.run())
        tasks.start(made.commands.run())
        await until(lambda: link.is_up)
        await texts.load()
        yield made


async def running(servicer: SimulatorServicer, command: pb2.Command = FAR) -> None:
    """Wait until the robot carries out a command."""
    await until(lambda: servicer.robot.jobs and servicer.robot.jobs[0].command == command)


async def test_a_command_ends_when_the_robot_says_so() -> None:
    async with simulated() as (servicer, address), adapter(address) as own:
        await own.commands.perform(FAR, "move", "go")
        assert servicer.robot.body.pose.x == pytest.approx(2.0)
        assert own.released == 1, "control by hand has ended before"
        assert own.commands.figures.begun == 1


async def test_a_command_that_the_robot_fails_to_do_fails_with_its_words() -> None:
    async with simulated() as (_, address), adapter(address) as own:
        with pytest.raises(ComponentFailed, match=r"did not go there: Unknown target: .* \(error 10002\)"):
            await own.commands.perform(NOWHERE, "navigation", "go there")


async def test_a_command_that_is_not_accepted_fails_with_the_robots_words() -> None:
    async with simulated() as (servicer, address), adapter(address) as own:
        servicer.robot.stop_in_emergency()
        with pytest.raises(ComponentFailed, match="the robot did not go: Emergency stop"):
            await own.commands.perform(FAR, "move", "go")


async def test_stop_cancels_at_the_robot_and_the_command_ends_with_the_reason() -> None:
    async with simulated(1.0) as (servicer, address), adapter(address) as own:
        going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
        await running(servicer)
        await own.commands.cancel("navigation", "another component's")
        assert servicer.robot.jobs, "that of this component goes on"
        await own.commands.cancel("move", "move was stopped")
        assert not servicer.robot.jobs
        assert isinstance(await ended(going), Aborted)
        assert len(servicer.robot.stops) == 1
        assert own.commands.figures.cancelled == 1


async def test_who_does_not_wait_any_more_does_not_leave_the_robot_driving() -> None:
    async with simulated(1.0) as (servicer, address), adapter(address) as own:
        going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
        await running(servicer)
        going.cancel()
        assert isinstance(await ended(going), asyncio.CancelledError)
        assert not servicer.robot.jobs


async def test_a_wait_that_ends_before_the_robot_has_answered_leaves_no_robot_driving() -> None:
    accepting = asyncio.Event()

    class Slow(SimulatorServicer):
        async def StartCommand(self, request: Any, context: Any) -> Any:  # noqa: N802
            response = await super().StartCommand(request, context)
            accepting.set()
            await asyncio.sleep(0.2)
            return response

    async with simulated(1.0, servicer=Slow) as (servicer, address), adapter(address) as own:
        going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
        await accepting.wait()
        assert servicer.robot.jobs
        going.cancel()
        assert isinstance(await ended(going), asyncio.CancelledError)
        assert not servicer.robot.jobs


async def test_a_wait_that_ends_at_any_moment_leaves_no_robot_driving_and_no_command_behind() -> None:
    async with simulated(1.0) as (servicer, address), adapter(address) as own:
        tasks = len(asyncio.all_tasks())
        for turn in range(24):
            going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
            speaking = asyncio.ensure_future(own.commands.perform(SPEAK, "speech", "speak", moves=False))
            # Loop turns first, then milliseconds: wherever the command is between being asked for and accepted.
            for _ in range(turn if turn < 12 else 0):
                await asyncio.sleep(0)
            if turn >= 12:
                await asyncio.sleep((turn - 12) * 0.001)
            for each in (going, speaking) if turn % 2 else (speaking, going):
                each.cancel()
            assert isinstance(await ended(going), asyncio.CancelledError)
            assert isinstance(await ended(speaking), asyncio.CancelledError)
            await until(lambda: not servicer.robot.jobs)
        assert own.commands._running == {}
        assert len(own.commands._tracking) == 0
        await until(lambda: len(asyncio.all_tasks()) <= tasks)
        await own.commands.perform(TURN, "move", "turn")


async def test_a_stop_before_the_robot_has_answered_counts() -> None:
    accepting = asyncio.Event()

    class Slow(SimulatorServicer):
        async def StartCommand(self, request: Any, context: Any) -> Any:  # noqa: N802
            response = await super().StartCommand(request, context)
            accepting.set()
            await asyncio.sleep(0.2)
            return response

    async with simulated(1.0, servicer=Slow) as (servicer, address), adapter(address) as own:
        going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
        await accepting.wait()
        await own.commands.cancel("move", "move was stopped")
        assert not servicer.robot.jobs
        assert str(await ended(going)) == "move was stopped"


async def test_a_foreign_command_is_neither_cancelled_nor_replaced() -> None:
    async with simulated(1.0) as (servicer, address), adapter(address) as own:
        _, foreign = servicer.robot.start(LOCK, cancel_all=False)
        with pytest.raises(OutOfResources, match="a command of another program \\(lock\\): wait for its end, or"):
            await own.commands.perform(FAR, "move", "go")
        await own.commands.cancel("move", "stopped")
        await own.commands.end_motion("stopped")
        assert [job.id for job in servicer.robot.jobs] == [foreign]
        assert not servicer.robot.stops


async def test_a_command_that_another_program_has_replaced_is_not_cancelled_a_second_time() -> None:
    async with simulated(1.0) as (servicer, address), adapter(address) as own:
        going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
        await running(servicer)
        _, foreign = servicer.robot.start(LOCK, cancel_all=True)
        error = await ended(going)
        assert isinstance(error, ComponentFailed)
        assert "Cancelled" in str(error)
        await own.commands.cancel("move", "stopped")
        assert [job.id for job in servicer.robot.jobs] == [foreign]


async def test_speech_behind_a_foreign_command_waits_and_when_given_up_ends_before_it_begins() -> None:
    async with simulated(1.0) as (servicer, address), adapter(address) as own:
        servicer.robot.start(LOCK, cancel_all=False)
        speaking = asyncio.ensure_future(own.commands.perform(SPEAK, "speech", "speak", moves=False))
        await until(lambda: len(servicer.robot.jobs) == 2)
        await own.commands.cancel("speech", "speech was stopped")
        assert [job.command for job in servicer.robot.jobs] == [LOCK, SPEAK], "only what runs can be cancelled"
        assert isinstance(await ended(speaking), Aborted)
        servicer.robot.cancel()
        await until(lambda: not servicer.robot.jobs)
        assert servicer.robot.last is not None
        assert servicer.robot.last.error.name == "CANCELLED"


async def test_a_new_motion_ends_the_one_before_it() -> None:
    async with simulated(1.0) as (servicer, address), adapter(address) as own:
        going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
        await running(servicer)
        await own.commands.perform(TURN, "dock", "turn")
        assert str(await ended(going)) == "dock has begun to turn"


@pytest.mark.parametrize("tells_history", [True, False])
async def test_of_two_results_at_once_neither_is_waited_for_for_ever(tells_history: bool) -> None:
    class Forgetful(SimulatorServicer):
        async def GetHistoryList(self, _request: Any, _context: Any) -> Any:  # noqa: N802
            return pb2.GetHistoryListResponse()

        async def GetLastCommandResult(self, request: Any, context: Any) -> Any:  # noqa: N802
            # The robot is asked only when both have ended: the answer has the second alone.
            await asked.wait()
            return await SimulatorServicer.GetLastCommandResult(self, request, context)

    class Remembering(Forgetful):
        async def GetHistoryList(self, request: Any, context: Any) -> Any:  # noqa: N802
            return await SimulatorServicer.GetHistoryList(self, request, context)

    asked = asyncio.Event()
    chosen = Remembering if tells_history else Forgetful
    settings = RobotSettings(speaks_while_driving=True)
    async with simulated(1.0, settings=settings, servicer=chosen) as (servicer, address), adapter(address) as own:
        going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
        await running(servicer)
        speaking = asyncio.ensure_future(own.commands.perform(SPEAK, "speech", "speak", moves=False))
        await until(lambda: servicer.robot.last is not None, 10)
        assert servicer.robot.last is not None
        assert servicer.robot.last.command == SPEAK
        servicer.robot.cancel()
        asked.set()
        failed, spoken = await ended(going), await ended(speaking)
        assert isinstance(failed, ComponentFailed)
        assert "Cancelled" in str(failed)
        if tells_history:
            assert spoken is None
        else:
            assert "told only the result of another command: whether it did is not known" in str(spoken)
            assert own.commands.figures.lost == 1


async def test_a_robot_that_is_restarted_in_the_middle_has_lost_its_command() -> None:
    async with simulator_process() as home, adapter(home.address) as own:
        going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
        await until(lambda: own.commands.figures.begun)
        await home.kill()
        await home.start_again()
        assert isinstance(await ended(going), ComponentFailed)
        await until(lambda: own.link.is_up)
        await own.commands.perform(TURN, "move", "turn")


async def test_what_was_given_up_while_the_robot_hung_is_cancelled_when_it_is_back() -> None:
    async with simulator_process() as home, adapter(home.address) as own:
        going = asyncio.ensure_future(own.commands.perform(FAR, "move", "go"))
        await until(lambda: own.commands.figures.begun)
        home.freeze()
        assert isinstance(await ended(going), ComponentFailed)
        home.thaw()
        await until(lambda: own.commands.figures.cancelled)
        state = await own.api.call("GetCommandState", deadline=10)
        assert state.command_id == ""


async def test_a_command_whose_acceptance_was_not_seen_is_cancelled() -> None:
    class Mute(SimulatorServicer):
        async def StartCommand(self, request: Any, context: Any) -> Any:  # noqa: N802
            await super().StartCommand(request, context)
            await asyncio.Event().wait()

    async with simulated(1.0, servicer=Mute) as (servicer, address), adapter(address) as own:
        with pytest.raises(ComponentFailed, match="StartCommand was not answered within 1 s"):
            await own.commands.perform(LOCK, "move", "go")
        await until(lambda: own.commands.figures.cancelled)
        assert not servicer.robot.jobs
