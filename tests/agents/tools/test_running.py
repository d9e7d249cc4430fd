"""A command that a call has begun: whatever ends the call first, the command is stopped."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from openrois_agents.tools.running import Runner

from openrois.aio.tasks import TaskScope
from openrois.client import BadParameter, ComponentProxy, TimedOut
from openrois.testing import harness
from tests.support.actors import Actor

pytestmark = pytest.mark.extra(name="mcp")


@asynccontextmanager
async def walking(actor: Actor) -> AsyncIterator[tuple[Runner, ComponentProxy]]:
    async with harness(*actor.parts) as client, TaskScope() as tasks:
        legs = client.component("robot/navigation")
        async with legs.bound():
            yield Runner(tasks, asyncio.get_running_loop().time), legs


async def quietly(_seconds: float, _message: str) -> None:
    pass


PARAMETERS = {"target_positions": ("plant",)}


async def test_what_crashes_stops_what_it_began() -> None:
    async def crash(_seconds: float, _message: str) -> None:
        raise ZeroDivisionError

    actor = Actor(at_once=False)
    async with walking(actor) as (runner, legs):
        with pytest.raises(ZeroDivisionError):
            await runner.run(legs, "start", crash, parameters=PARAMETERS)
        await actor.walking.stopped.wait()


async def test_what_takes_too_long_is_stopped() -> None:
    actor = Actor(at_once=False)
    async with walking(actor) as (runner, legs):
        with pytest.raises(TimedOut, match=r"took longer than 0\.05 s and was stopped"):
            await runner.run(legs, "start", quietly, parameters=PARAMETERS, seconds=0.05)
        await actor.walking.stopped.wait()


async def test_what_was_refused_or_has_ended_is_not_stopped() -> None:
    actor = Actor()
    async with walking(actor) as (runner, legs):
        await runner.run(legs, "start", quietly, parameters=PARAMETERS)
        with pytest.raises(BadParameter):
            await runner.run(legs, "start", quietly, parameters={"target_positions": 7})
        with pytest.raises(BadParameter):
            await runner.run(legs, "start", quietly, arguments={"fast": True})
        assert actor.walking.stops == 0


async def test_the_next_call_begins_when_the_last_one_was_stopped() -> None:
    actor = Actor(at_once=False)
    async with walking(actor) as (runner, legs):
        first = asyncio.ensure_future(runner.run(legs, "start", quietly, parameters=PARAMETERS))
        await actor.walking.begun.wait()
        second = asyncio.ensure_future(runner.run(legs, "start", quietly, parameters={"target_positions": ("door",)}))
        first.cancel()
        await actor.walking.stopped.wait()
        actor.walking.may_end.set()
        await second
        assert (actor.walking.did, actor.walking.stops) == (["plant", "door"], 1)


async def test_a_call_that_waits_for_its_turn_and_is_cancelled_stops_nothing() -> None:
    actor = Actor(at_once=False)
    async with walking(actor) as (runner, legs):
        first = asyncio.ensure_future(runner.run(legs, "start", quietly, parameters=PARAMETERS))
        await actor.walking.begun.wait()
        second = asyncio.ensure_future(runner.run(legs, "start", quietly, parameters=PARAMETERS))
        await asyncio.sleep(0)
        second.cancel()
        await asyncio.wait({second})
        actor.walking.may_end.set()
        await first
        assert (actor.walking.did, actor.walking.stops) == (["plant"], 0)


async def test_a_host_that_reads_no_progress_holds_nothing_up(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois_agents.tools.running._REPORT", 0.01)

    async def never(_seconds: float, _message: str) -> None:
        await asyncio.Event().wait()

    async with walking(Actor()) as (runner, legs):
        await runner.run(legs, "start", never, parameters=PARAMETERS)


async def test_news_of_the_component_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("openrois_agents.tools.running._REPORT", 0.05)
    actor, told, reported = Actor(at_once=False), list[str](), asyncio.Event()
    progressed = asyncio.Event()

    async def note(_seconds: float, message: str) -> None:
        told.append(message)
        progressed.set()
        if message.startswith('reached_target of robot/navigation: {"target": "kitchen"'):
            reported.set()

    async with walking(actor) as (runner, legs):
        run = asyncio.ensure_future(
            runner.run(legs, "start", note, parameters=PARAMETERS, news=(legs, "reached_target"))
        )
        await actor.walking.begun.wait()
        legs_here = actor.parts[2]
        async with asyncio.timeout(30):
            while not reported.is_set():
                # When the call has subscribed is not told.
                legs_here.reached_target(target="kitchen", is_final_target=False)  # type: ignore[attr-defined]
                await progressed.wait()
                progressed.clear()
        actor.walking.may_end.set()
        await run
    assert told[0] == "start of robot/navigation runs"
