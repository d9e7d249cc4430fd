"""One motion at a time, and how each one ends."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

import pytest
from openrois_body.messages import (
    Command,
    Completed,
    Drive,
    Halt,
    LinkError,
    Log,
    Place,
    Reached,
    Status,
    Walk,
    Waypoint,
)
from openrois_body.motion.legs import Ended, Legs, Motion

from openrois.errors import Aborted, ComponentFailed, TimedOut
from tests.support.streaming import VirtualClock, settle

PATH = (Waypoint(1, 0), Waypoint(1, 1, 0.5))


class Stage:
    """Legs in an engine that keeps the commands it receives; it can be gone, and lame."""

    def __init__(self) -> None:
        self.told: list[Command] = []
        self.gone = False
        self.walks = True
        self.place: Place | None = Place(0, 0, 0)
        self.clock = VirtualClock()
        self.legs = Legs(self._tell, lambda: self.walks, lambda: self.place, self.clock)
        self.indices: list[int] = []

    def _tell(self, command: Command) -> None:
        if self.gone:
            raise LinkError("the engine is gone")
        self.told.append(command)

    @property
    def walk_id(self) -> str:
        told = [command for command in self.told if isinstance(command, Walk)]
        return told[-1].id

    def kinds(self) -> list[str]:
        return [type(command).__name__ for command in self.told]

    def run(
        self, name: str, work: Callable[[Motion], Coroutine[Any, Any, Ended]] | None = None
    ) -> "asyncio.Task[Ended]":
        async def running() -> Ended:
            async with self.legs.motion(name) as motion:
                return await (work(motion) if work else motion.walk(PATH, 1.0, self.indices.append))

        return asyncio.ensure_future(running())


@pytest.fixture
def stage() -> Stage:
    return Stage()


@pytest.mark.parametrize("status", ["OK", "ABORT"])
async def test_a_walk_tells_its_points_and_its_end(stage: Stage, status: Status) -> None:
    walking = stage.run("Navigation")
    await settle()
    assert stage.told == [Walk(stage.walk_id, PATH, 1.0)]
    assert not walking.done()
    for event in (
        Reached("another", 0),
        Reached(stage.walk_id, 0),
        Log("a line"),
        Completed("another", "ERROR"),
        Reached(stage.walk_id, 1),
        Completed(stage.walk_id, status),
        Completed(stage.walk_id, "ERROR"),
        Reached(stage.walk_id, 0),
    ):
        stage.legs.handle_event(event)
    assert await walking == status
    assert stage.indices == [0, 1]
    assert stage.kinds() == ["Walk"], "a figure that has arrived stands"
    stage.legs.handle_event(Completed(stage.walk_id, "OK"))


async def test_walk_that_the_engine_cannot_do_fails(stage: Stage) -> None:
    walking = stage.run("Navigation")
    await settle()
    stage.legs.handle_event(Completed(stage.walk_id, "ERROR"))
    with pytest.raises(ComponentFailed, match="the body cannot go there"):
        await walking


async def test_a_walk_fails_with_the_reason_that_the_body_gives(stage: Stage) -> None:
    walking = stage.run("Navigation")
    await settle()
    stage.legs.handle_event(Completed(stage.walk_id, "ERROR", "stuck 0.46 m before the goal"))
    with pytest.raises(ComponentFailed, match=r"^stuck 0\.46 m before the goal$"):
        await walking


async def test_a_walk_is_no_faster_than_the_body(stage: Stage) -> None:
    stage.legs.top_speed = 0.3
    stage.run("Navigation", lambda motion: motion.walk((Waypoint(6, 0),), 1.0))
    await settle()
    assert stage.told == [Walk(stage.walk_id, (Waypoint(6, 0),), 0.3)]


async def test_cancelling_a_motion_halts_the_figure(stage: Stage) -> None:
    walking = stage.run("Navigation")
    await settle()
    walking.cancel()
    with pytest.raises(asyncio.CancelledError):
        await walking
    assert stage.kinds() == ["Walk", "Halt"]


async def test_a_new_motion_ends_the_one_before(stage: Stage) -> None:
    first = stage.run("Navigation")
    await settle()
    old = stage.walk_id
    second = stage.run("Move")
    await settle()
    with pytest.raises(Aborted, match="Navigation was ended: Move has the body now"):
        await first
    assert stage.kinds() == ["Walk", "Halt", "Walk"]
    stage.legs.handle_event(Completed(old, "ABORT"))
    stage.legs.handle_event(Completed(stage.walk_id, "OK"))
    assert await second == "OK"


async def test_a_hand_comes_first(stage: Stage) -> None:
    walking = stage.run("Follow")
    await settle()
    stage.legs.drive(0.5, 0.0, -0.25)
    with pytest.raises(Aborted, match="an operator drives the body by hand"):
        await walking
    assert stage.told[1:] == [Halt(), Drive(0.5, 0.0, -0.25)]


async def test_halting_says_why(stage: Stage) -> None:
    walking = stage.run("Move")
    await settle()
    stage.legs.halt("the operator is gone")
    with pytest.raises(Aborted, match="Move was ended: the operator is gone"):
        await walking
    assert stage.kinds()[-1] == "Halt"


async def test_a_figure_that_has_no_motion_is_told_to_stand(stage: Stage) -> None:
    stage.legs.stand()
    assert stage.told == [Halt()]
    walking = stage.run("Move")
    await settle()
    stage.legs.stand()
    assert stage.kinds() == ["Halt", "Walk"]
    stage.legs.handle_event(Completed(stage.walk_id, "OK"))
    assert await walking == "OK"
    stage.gone = True
    stage.legs.stand()


async def test_a_lost_engine_fails_a_motion_also_while_it_waits(stage: Stage) -> None:
    stage.legs.engine_lost()

    async def waits(_motion: Motion) -> Ended:
        await asyncio.get_running_loop().create_future()
        return "OK"

    waiting = stage.run("Follow", waits)
    await settle()
    stage.gone = True
    stage.legs.engine_lost()
    stage.legs.engine_lost()
    with pytest.raises(ComponentFailed, match="the body is disconnected"):
        await waiting


async def test_without_an_engine_that_walks_nothing_is_sent(stage: Stage) -> None:
    stage.walks = False
    assert not stage.legs.can_walk
    with pytest.raises(ComponentFailed, match="no body that moves"):
        await stage.run("Move")
    with pytest.raises(ComponentFailed, match="no body that moves"):
        stage.legs.drive(1, 0, 0)
    stage.legs.halt("no viewer is there")
    assert stage.told == []
    stage.walks, stage.gone = True, True
    with pytest.raises(ComponentFailed, match="gone"):
        await stage.run("Move")
    stage.legs.halt("no viewer is there")


async def test_an_interrupted_walk_goes_on_until_another_replaces_it(stage: Stage) -> None:
    async def twice(motion: Motion) -> Ended:
        motion.interrupt()
        asyncio.get_running_loop().call_soon(motion.interrupt)
        assert await motion.walk(PATH, 1.0) == "INTERRUPTED"
        return await motion.walk(PATH[1:], 1.0)

    walking = stage.run("Follow", twice)
    await settle()
    assert stage.kinds() == ["Walk", "Walk"]
    stage.legs.handle_event(Completed(stage.walk_id, "OK"))
    assert await walking == "OK"


async def test_running_walk_is_halted_at_the_end_of_a_motion(stage: Stage) -> None:
    async def leaves(motion: Motion) -> Ended:
        asyncio.get_running_loop().call_soon(motion.interrupt)
        return await motion.walk(PATH, 1.0)

    assert await stage.run("Follow", leaves) == "INTERRUPTED"
    assert stage.kinds() == ["Walk", "Halt"]


async def test_end_of_a_walk_is_noted_while_no_task_waits(stage: Stage) -> None:
    going_on: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    async def thinks(motion: Motion) -> Ended:
        asyncio.get_running_loop().call_soon(motion.interrupt)
        ended = await motion.walk(PATH, 1.0)
        await going_on
        return ended

    walking = stage.run("Follow", thinks)
    await settle()
    stage.legs.handle_event(Completed(stage.walk_id, "OK"))
    going_on.set_result(None)
    await walking
    assert stage.kinds() == ["Walk"]


async def test_an_engine_that_forgets_a_walk_fails_it(stage: Stage) -> None:
    walking = stage.run("Navigation")
    await stage.clock.advance(19.9)
    assert not walking.done()
    await stage.clock.advance(0.2)
    with pytest.raises(ComponentFailed, match="has not ended a walk for 20 s"):
        await walking
    assert stage.kinds() == ["Walk", "Halt"]


async def test_a_walk_from_nowhere_has_its_time_too(stage: Stage) -> None:
    stage.place = None
    walking = stage.run("Navigation")
    await stage.clock.advance(17.9)
    assert not walking.done()
    await stage.clock.advance(0.2)
    with pytest.raises(ComponentFailed, match="18 s"):
        await walking


async def test_the_first_reason_counts_and_a_cancelled_task_stays_cancelled(stage: Stage) -> None:
    motion = stage.legs.motion("Move")
    reasons = (TimedOut("too late"), Aborted("by another"))

    async def running() -> None:
        async with motion:
            await asyncio.get_running_loop().create_future()

    task = asyncio.ensure_future(running())
    await settle()
    for reason in reasons:
        motion.fail(reason)
    with pytest.raises(TimedOut):
        await task
    motion.fail(reasons[0])

    motion = stage.legs.motion("Move")
    task = asyncio.ensure_future(running())
    await settle()
    task.cancel()
    motion.fail(reasons[0])
    with pytest.raises(asyncio.CancelledError):
        await task
