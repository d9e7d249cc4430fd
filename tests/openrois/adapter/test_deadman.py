"""What moves stops when no application is in control of it, or when that cannot be known."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from dataclasses import dataclass, field

import pytest

from openrois.adapter import components, running
from openrois.adapter.deadman import ALLOWANCE, DeadMan, HolderExtension
from openrois.aio.tasks import TaskScope
from openrois.component.authoring.marks import command
from openrois.component.component import DEAD_MAN, Component
from openrois.contract import Client
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.errors import Aborted, Unsupported
from openrois.jsonrpc.heartbeat import Heartbeat
from openrois.types.streams import HolderNotification
from tests.support import wire
from tests.support.components import Lamp, Rover
from tests.support.deployment import patience
from tests.support.streams import FakeStreams

pytestmark = pytest.mark.extra(name="gateway")

ROVER = "r/rover"
COMPLETED = "rois.command.completed"


class Winch(Component, authority="Test", function="actuation"):
    """Has no `stop`."""

    dead_man = 0.2

    @command
    async def pull(self) -> None:
        await asyncio.Event().wait()


@dataclass
class Time:
    """Time that passes when a test says so; sleeps end when their time has come."""

    now: float = 100.0
    sleepers: list[tuple[float, asyncio.Future[None]]] = field(default_factory=list)

    def clock(self) -> float:
        return self.now

    async def sleep(self, seconds: float) -> None:
        if seconds > 0:
            woken: asyncio.Future[None] = asyncio.get_running_loop().create_future()
            self.sleepers.append((self.now + seconds, woken))
            await woken

    async def pass_by(self, seconds: float) -> None:
        self.now += seconds
        for due, woken in self.sleepers:
            if due <= self.now + 1e-9 and not woken.done():
                woken.set_result(None)
        await settle()


async def settle() -> None:
    for _ in range(20):
        await asyncio.sleep(0)


@dataclass
class Robot:
    time: Time
    heartbeat: Heartbeat
    deadman: DeadMan
    registry: LocalRegistry
    rover: Rover
    asked: list[bool]

    def run(self, command_type: str = "start", component_ref: str = ROVER) -> "asyncio.Task[object]":
        return asyncio.ensure_future(self.registry.invoke(component_ref, command_type))

    async def driving(self, command_type: str = "start") -> "asyncio.Task[object]":
        running = self.run(command_type)
        await settle()
        assert self.rover.driving.is_set()
        return running


@pytest.fixture
async def robot() -> AsyncIterator[Robot]:
    time, asked = Time(), list[bool]()
    heartbeat, rover = Heartbeat(time.clock), Rover()
    async with TaskScope() as tasks:
        deadman = DeadMan(heartbeat, tasks, time.clock, time.sleep)
        registry = LocalRegistry("r", (rover, Winch("winch"), Lamp()))
        registry.guard = deadman.guard
        heartbeat.attach(asked.append)
        for component_ref in (ROVER, "r/winch"):
            deadman.take_holder(HolderNotification(component_ref=component_ref, holds=True, epoch=1), client("ann"))
        yield Robot(time, heartbeat, deadman, registry, rover, asked)


async def aborted(running: "asyncio.Task[object]") -> str:
    with pytest.raises(Aborted) as ended:
        async with patience():
            await running
    return str(ended.value)


def test_what_moves_has_one_by_itself() -> None:
    moving = (components.Navigation, components.Move, components.Follow)
    assert {kind.dead_man for kind in moving} == {DEAD_MAN} == {0.5}
    assert components.SpeechSynthesis.dead_man is None


@pytest.mark.parametrize("command_type", ["start", "turn"])
async def test_without_a_sign_of_life_it_stops(robot: Robot, command_type: str) -> None:
    running = await robot.driving(command_type)
    await robot.time.pass_by(0.3)
    robot.heartbeat.sign()
    await robot.time.pass_by(0.1)
    await robot.time.pass_by(DEAD_MAN - ALLOWANCE - 0.11)
    assert not robot.rover.stopped.is_set()
    await robot.time.pass_by(0.015)
    assert robot.rover.stopped.is_set()
    assert "no sign of life from the gateway for 0.4" in await aborted(running)


async def test_signs_are_wanted_only_while_something_moves(robot: Robot) -> None:
    running = await robot.driving()
    assert robot.asked == [True]
    assert await robot.registry.invoke(ROVER, "stop") == ()
    await aborted(running)
    assert robot.asked == [True, False]
    await robot.time.pass_by(10)


async def test_what_came_while_this_process_did_not_run_is_read_first(robot: Robot) -> None:
    running = await robot.driving()
    await robot.time.pass_by(5)
    assert not robot.rover.stopped.is_set()
    robot.heartbeat.sign()
    await robot.time.pass_by(0.1)
    assert not running.done()
    robot.heartbeat.cut("the cable is out")
    assert "the cable is out" in await aborted(running)


async def test_a_gateway_that_gives_no_signs_is_missed_when_it_is_gone(robot: Robot) -> None:
    robot.heartbeat.cut("gone")
    running = await robot.driving()
    await robot.time.pass_by(0.45)
    await robot.time.pass_by(10)
    assert not robot.rover.stopped.is_set()
    robot.heartbeat.attach(robot.asked.append)
    assert robot.asked == [True]
    robot.heartbeat.cut("gone again")
    await aborted(running)
    assert robot.rover.stopped.is_set()


async def test_a_brake_that_fails_is_no_reason_to_wait(robot: Robot) -> None:
    robot.rover.fails = True
    running = await robot.driving("turn")
    robot.heartbeat.cut("gone")
    await aborted(running)


async def test_what_has_no_stop_is_cancelled(robot: Robot) -> None:
    running = robot.run("pull", "r/winch")
    await settle()
    await robot.time.pass_by(0.105)
    assert "winch" in await aborted(running)


async def test_what_may_go_on_goes_on(robot: Robot) -> None:
    running = robot.run("start", "r/lamp")
    await settle()
    robot.heartbeat.cut("gone")
    await robot.time.pass_by(10)
    assert not running.done()
    running.cancel()


async def test_twice_is_stopped_twice(robot: Robot) -> None:
    for _ in range(2):
        running = await robot.driving()
        robot.rover.driving.clear()
        robot.rover.stopped.clear()
        robot.heartbeat.cut("gone")
        await aborted(running)
        assert robot.rover.stopped.is_set()


async def test_a_stop_that_comes_at_the_same_moment_ends_the_start_before_it(robot: Robot) -> None:
    running, stopping = robot.run(), robot.run("stop")
    assert await aborted(running) == "rover was stopped"
    await stopping
    assert not robot.rover.driving.is_set()


async def test_a_cancelled_caller_leaves_nothing_running(robot: Robot) -> None:
    running = await robot.driving()
    running.cancel()
    await asyncio.wait({running})
    assert robot.asked == [True, False]


def client(name: str) -> Client:
    return Client(name, lambda _method, _params: None)


def held(by: Client, epoch: int, robot: Robot, *, holds: bool = True) -> None:
    robot.deadman.take_holder(HolderNotification(component_ref=ROVER, holds=holds, epoch=epoch), by)


async def test_nothing_begins_to_move_for_a_departed_application(robot: Robot) -> None:
    ann = client("ann")
    held(ann, 2, robot)
    robot.deadman.forget_client(ann)
    assert "no application has control" in await aborted(robot.run())
    held(ann, 3, robot)
    held(ann, 3, robot, holds=False)
    assert "no application has control" in await aborted(robot.run("turn"))
    assert await robot.registry.invoke(ROVER, "stop") == ()
    assert not robot.rover.driving.is_set()
    assert robot.asked == []
    held(ann, 4, robot)
    (await robot.driving()).cancel()


async def test_it_moves_only_for_its_holder(robot: Robot) -> None:
    ann, bob = client("ann"), client("bob")
    held(ann, 1, robot)
    running = await robot.driving()
    held(ann, 1, robot)
    held(bob, 1, robot, holds=False)
    robot.deadman.forget_client(bob)
    await settle()
    assert not running.done()
    held(ann, 1, robot, holds=False)
    assert "no application has control" in await aborted(running)
    held(ann, 2, robot)
    running = await robot.driving()
    held(bob, 3, robot)
    assert "changed hands" in await aborted(running)
    running = await robot.driving()
    robot.deadman.forget_client(bob)
    assert "is gone" in await aborted(running)


async def test_the_extension_below_hears_the_same(robot: Robot) -> None:
    streams = FakeStreams()
    both, none = HolderExtension(robot.deadman, streams, {}), HolderExtension(robot.deadman, None, {})
    ann = client("ann")
    holds = HolderNotification(component_ref=ROVER, holds=True, epoch=1)
    assert (both.engines(), none.engines()) == (streams.engines(), frozenset())
    for extension in (both, none):
        await extension.set_holder(holds, ann)
        await extension.forget_client(ann)
    assert [name for name, _, _ in streams.calls] == [HolderNotification.method]
    with pytest.raises(Unsupported):
        await none.call("rois.stream.connect_stream", {}, ann)


async def test_a_component_that_fails_as_its_holder_leaves_keeps_nothing_from_the_extension_below(robot: Robot) -> None:
    class Failing(Winch, authority="Test", function="actuation"):
        def holder_lost(self) -> None:
            raise ValueError("a mistake of the component")

    streams, ann = FakeStreams(), client("ann")
    extension = HolderExtension(robot.deadman, streams, {ROVER: Failing("rover")})
    for holds in (True, False):
        await extension.set_holder(HolderNotification(component_ref=ROVER, holds=holds, epoch=1), ann)
    assert [name for name, _, _ in streams.calls] == [HolderNotification.method] * 2


async def test_the_rest_of_a_sequence_does_not_move_when_its_sender_has_left() -> None:
    rover, lamp = Rover(), Lamp()
    async with AsyncExitStack() as stack:
        host = await stack.enter_async_context(wire.hosted(Engine("gateway")))
        below = await stack.enter_async_context(running.hosted("r", rover, lamp))
        await stack.enter_async_context(wire.adapter_leg(host, below))
        app = await stack.enter_async_context(wire.application(host))
        other = await stack.enter_async_context(wire.application(host))
        for component_ref in (ROVER, "r/lamp"):
            assert (await app.ask("rois.command.bind", component_ref=component_ref))["return_code"] == "OK"
        units = [
            {"component_ref": component_ref, "command_type": "start", "command_id": command_id}
            for component_ref, command_id in (("r/lamp", "first"), (ROVER, "then"))
        ]
        assert (await app.ask("rois.command.execute", command_unit_list=units))["return_code"] == "OK"
        async with patience():
            await lamp.glowing.wait()
        assert (await app.ask("rois.system.disconnect"))["return_code"] == "OK"
        lamp.may_end.set()
        ended = {told["command_id"]: told["status"] for told in [await app.next(COMPLETED), await app.next(COMPLETED)]}
        assert ended == {"first": "OK", "then": "ABORT"}
        assert not rover.driving.is_set()
        # The holder moves it.
        assert (await other.ask("rois.command.bind", component_ref=ROVER))["return_code"] == "OK"
        assert (await other.ask("rois.command.execute", command_unit_list=units[1:]))["return_code"] == "OK"
        async with patience():
            await rover.driving.wait()


async def test_what_moves_stops_when_the_holder_changes_connections() -> None:
    rover = Rover()
    async with AsyncExitStack() as stack:
        host = await stack.enter_async_context(wire.hosted(Engine("gateway")))
        below = await stack.enter_async_context(running.hosted("r", rover))
        await stack.enter_async_context(wire.adapter_leg(host, below))
        app = await stack.enter_async_context(wire.application(host))
        again = await stack.enter_async_context(wire.application(host))
        token = (await app.ask("openrois.lease.token"))["token"]
        assert (await app.ask("rois.command.bind", component_ref=ROVER))["return_code"] == "OK"
        unit = {"component_ref": ROVER, "command_type": "start", "command_id": "drive"}
        assert (await app.ask("rois.command.execute", command_unit_list=[unit]))["return_code"] == "OK"
        async with patience():
            await rover.driving.wait()
        assert (await again.ask("openrois.lease.resume", token=token))["return_code"] == "OK"
        told = await again.next(COMPLETED)
        assert (told["command_id"], told["status"], rover.stopped.is_set()) == ("drive", "ABORT", True)
        rover.driving.clear()
        unit["command_id"] = "on"
        assert (await again.ask("rois.command.execute", command_unit_list=[unit]))["return_code"] == "OK"
        async with patience():
            await rover.driving.wait()
