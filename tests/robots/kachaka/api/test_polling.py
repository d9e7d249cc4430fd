"""Long polls: each state once, a pause where the robot does not wait, and a robot that counts anew."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any, cast

import pytest
from kachaka_api.generated import kachaka_api_pb2 as pb2
from openrois_robots.kachaka.api.calls import KachakaApi, RobotSilent
from openrois_robots.kachaka.api.polling import Poll

from tests.support.streaming import VirtualClock, settle


class Script:
    """An API whose answers are cursors; None is a request that is not answered in time."""

    def __init__(self, *cursors: int | None) -> None:
        self.left = list(cursors)
        self.asked: list[int] = []

    async def call(self, method: str, request: pb2.GetRequest, *, deadline: float) -> Any:
        assert method == "GetError"
        assert deadline >= 1
        self.asked.append(request.metadata.cursor)
        if not self.left:
            await asyncio.Event().wait()
        cursor = self.left.pop(0)
        if cursor is None:
            raise RobotSilent("not answered")
        return pb2.GetErrorResponse(metadata=pb2.Metadata(cursor=cursor))


def poll(script: Script, clock: VirtualClock) -> Poll:
    return Poll(cast("KachakaApi", script), "GetError", clock)


async def next_cursor(poll: Poll) -> int:
    return int((await poll.next()).metadata.cursor)


async def soon(work: Callable[[], Awaitable[int]], clock: VirtualClock) -> int:
    """Return what a work returns, while time passes."""
    waiting = asyncio.ensure_future(work())
    for _ in range(100):
        await settle()
        if waiting.done():
            break
        await clock.advance(0.05)
    return await waiting


async def test_the_present_state_comes_first_and_then_each_change() -> None:
    script = Script(7, 9)
    states = poll(script, VirtualClock())
    assert [await next_cursor(states), await next_cursor(states)] == [7, 9]
    assert script.asked == [0, 7]


async def test_a_robot_that_answers_at_once_without_news_is_not_asked_without_an_end() -> None:
    clock = VirtualClock()
    script = Script(7, 7, 7, 8)
    states = poll(script, clock)
    assert await next_cursor(states) == 7
    waiting = asyncio.ensure_future(states.next())
    await settle()
    assert len(script.asked) == 2, "it pauses"
    for asked in (3, 4):
        await clock.advance(0.1)
        await settle()
        assert len(script.asked) == asked
    assert (await waiting).metadata.cursor == 8


async def test_a_change_that_does_not_come_is_asked_for_without_the_cursor() -> None:
    script = Script(900, None, 3)
    states = poll(script, VirtualClock())
    assert await next_cursor(states) == 900
    assert await next_cursor(states) == 3, "the robot was restarted, and counts from the beginning"
    assert script.asked == [0, 900, 0]


async def test_what_has_not_changed_meanwhile_is_no_news() -> None:
    clock = VirtualClock()
    script = Script(5, None, 5, 6)
    states = poll(script, clock)
    assert await next_cursor(states) == 5
    assert await soon(lambda: next_cursor(states), clock) == 6
    assert script.asked == [0, 5, 0, 5]


async def test_a_cursor_may_be_any_number() -> None:
    states = poll(Script(-1, -2, 2**63 - 1), VirtualClock())
    assert [await next_cursor(states) for _ in range(3)] == [-1, -2, 2**63 - 1]


async def test_a_robot_that_gives_no_cursors_is_asked_ten_times_a_second_and_what_it_tells_counts() -> None:
    clock = VirtualClock()
    script = Script(0, 0, 0)
    states = poll(script, clock)
    assert await next_cursor(states) == 0
    waiting = asyncio.ensure_future(next_cursor(states))
    await settle()
    assert len(script.asked) == 2
    assert not waiting.done(), "it pauses"
    await clock.advance(0.1)
    assert await waiting == 0


async def test_a_robot_that_does_not_even_tell_its_state_is_silent() -> None:
    states = poll(Script(5, None, None), VirtualClock())
    await states.next()
    with pytest.raises(RobotSilent):
        await states.next()


async def test_a_restart_asks_for_the_present_state() -> None:
    script = Script(5, 5)
    states = poll(script, VirtualClock())
    await states.next()
    states.restart()
    assert await next_cursor(states) == 5
    assert script.asked == [0, 0]
