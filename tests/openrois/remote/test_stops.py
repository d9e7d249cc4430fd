"""However many stops are requested, one of a component is on its way; requests meanwhile share the next."""

import asyncio
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field

import pytest

from openrois.aio.tasks import TaskScope
from openrois.errors import ComponentFailed, RoISError
from openrois.remote import stops as module
from openrois.remote.stops import SharedStops
from openrois.types.messages import Result

ARM, LEG = "robot/arm", "robot/leg"


@dataclass
class Sent:
    component_ref: str
    accept: Callable[[], None]
    ended: asyncio.Future[tuple[Result, ...]]


@dataclass
class Robot:
    """What is sent to it, and the tasks that wait for that."""

    tasks: TaskScope
    sent: list[Sent] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.stops = SharedStops(self._run, self.tasks)

    async def _run(self, component_ref: str, _command_id: str, accepted: Callable[[], None]) -> tuple[Result, ...]:
        self.sent.append(Sent(component_ref, accepted, asyncio.get_running_loop().create_future()))
        return await self.sent[-1].ended

    async def ask(self, count: int = 1, component_ref: str = ARM) -> list[asyncio.Task[tuple[Result, ...]]]:
        asked = [asyncio.create_task(self.stops.join(component_ref)) for _ in range(count)]
        await settled()
        return asked


async def settled() -> None:
    """Let everything run that can."""
    for _ in range(20):
        await asyncio.sleep(0)


@pytest.fixture
async def robot() -> AsyncIterator[Robot]:
    async with TaskScope() as tasks:
        yield Robot(tasks)


async def test_a_request_while_one_is_on_its_way_shares_the_next(robot: Robot) -> None:
    first = await robot.ask(3)
    assert len(robot.sent) == 1
    later = [*await robot.ask(100), *await robot.ask(100)]
    await robot.ask(1, LEG)
    assert [each.component_ref for each in robot.sent] == [ARM, LEG]
    robot.sent[0].ended.set_result(())
    assert await asyncio.gather(*first) == [()] * 3
    await settled()
    assert [each.component_ref for each in robot.sent] == [ARM, LEG, ARM]
    assert not any(each.done() for each in later)
    robot.sent[2].ended.set_result(())
    await asyncio.gather(*later)
    await robot.ask()
    assert len(robot.sent) == 4


async def test_one_that_takes_long_does_not_hold_up_the_next_once_it_is_accepted(robot: Robot) -> None:
    (first,), (second,) = await robot.ask(), await robot.ask()
    assert len(robot.sent) == 1
    robot.sent[0].accept()
    await settled()
    assert len(robot.sent) == 2
    robot.sent[1].ended.set_result(())
    assert await second == ()
    assert not first.done()


async def test_one_that_is_not_accepted_does_not_either(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "STOP_TIMEOUT", 0.0)
    await robot.ask()
    await robot.ask()
    await robot.stops.sent(ARM)
    await settled()
    assert len(robot.sent) == 2
    robot.sent[0].ended.set_result(())
    await settled()
    monkeypatch.undo()
    await robot.ask()
    # The second is still on its way: that the first has ended does not change it.
    assert len(robot.sent) == 2


async def test_it_is_sent_also_when_its_caller_is_gone_and_then_dropped(robot: Robot) -> None:
    (first,), (second,) = await robot.ask(), await robot.ask()
    first.cancel()
    second.cancel()
    await settled()
    assert len(robot.sent) == 1
    robot.sent[0].accept()
    await settled()
    assert robot.sent[0].ended.cancelled()
    assert len(robot.sent) == 2
    robot.sent[1].accept()
    await settled()
    assert len(robot.tasks) == 0


async def test_a_failure_fails_every_caller(robot: Robot) -> None:
    first, later = await robot.ask(2), await robot.ask(2)
    robot.sent[0].ended.set_exception(ComponentFailed("it jams"))
    for each in first:
        with pytest.raises(RoISError, match="it jams"):
            await each
    await settled()
    robot.sent[1].ended.set_result(())
    await asyncio.gather(*later)


async def test_what_is_asked_behind_one_that_waits_is_sent_behind_it(robot: Robot) -> None:
    await robot.stops.sent(ARM)
    await robot.ask()
    await robot.stops.sent(ARM)
    await robot.ask()
    behind = asyncio.ensure_future(robot.stops.sent(ARM))
    await settled()
    assert not behind.done()
    robot.sent[0].accept()
    await behind
    assert len(robot.sent) == 2
