"""STOP does not wait for what does not answer."""

import asyncio

import pytest

from openrois.aio.tasks import TaskScope
from openrois.commands import stop
from openrois.commands.pending import PendingCommands
from openrois.commands.stop import PAUSE, STOP_TIMEOUT, stop_components
from openrois.component.authoring.marks import command
from openrois.component.component import Component
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry


class Deaf(Component, authority="Test", function="actuation"):
    """Never says that it has stopped."""

    @command
    async def stop(self) -> None:
        await asyncio.Event().wait()


async def test_what_does_not_answer_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    assert STOP_TIMEOUT == 1.0
    monkeypatch.setattr(stop, "STOP_TIMEOUT", 0.001)
    engine = Engine("robot")
    await engine.attach(LocalRegistry("robot", [Deaf("arm"), Deaf("leg")]))
    refs = ("robot/arm", "robot/leg", "robot/none")
    async with TaskScope() as tasks:
        failures = await stop_components(engine, PendingCommands(), tasks, refs, "everything stops")
    assert failures == {**dict.fromkeys(refs[:2], "no answer within 0.001 s"), "robot/none": ""}


async def test_what_several_ask_for_before_it_has_begun_is_done_once_and_goes_on_without_them() -> None:
    engine, begun = Engine("robot"), asyncio.Semaphore(0)

    class Arm(Component, authority="Test", function="actuation"):
        @command
        async def stop(self) -> None:
            begun.release()

    await engine.attach(LocalRegistry("robot", [Arm("arm")]))
    async with TaskScope() as tasks:
        accepted = PendingCommands()

        def ask() -> asyncio.Future[dict[str, str]]:
            return asyncio.ensure_future(stop_components(engine, accepted, tasks, ("robot/arm",), "everything stops"))

        assert await asyncio.gather(*(ask() for _ in range(3))) == [{"robot/arm": ""}] * 3
        await begun.acquire()
        assert begun.locked()
        gone = ask()
        await asyncio.sleep(0)
        gone.cancel()
        assert await ask() == {"robot/arm": ""}
        await begun.acquire()
        assert not accepted.stops
        assert await stop_components(engine, accepted, tasks, (), "nothing stops") == {}


async def test_a_request_while_it_stops_shares_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    assert PAUSE == 0.05
    engine, told, may_end = Engine("robot"), asyncio.Queue[None](), asyncio.Event()

    class Arm(Component, authority="Test", function="actuation"):
        @command
        async def stop(self) -> None:
            told.put_nowait(None)
            await may_end.wait()

    await engine.attach(LocalRegistry("robot", [Arm("arm")]))
    async with TaskScope() as tasks:
        accepted = PendingCommands()

        async def ask(count: int) -> list[asyncio.Task[dict[str, str]]]:
            asked = [
                asyncio.create_task(stop_components(engine, accepted, tasks, ("robot/arm",), "everything stops"))
                for _ in range(count)
            ]
            await asyncio.sleep(0)
            return asked

        # One that has not ended keeps the next from beginning for the pause, and one that has does not.
        monkeypatch.setattr(stop, "PAUSE", 60.0)
        monkeypatch.setattr(stop, "STOP_TIMEOUT", 60.0)
        asked = await ask(3)
        await told.get()
        for _ in range(3):
            asked += await ask(2)
        assert told.empty()
        may_end.set()
        assert await asyncio.gather(*asked) == [{"robot/arm": ""}] * 9
        assert told.qsize() == 1
        may_end.clear()
        monkeypatch.setattr(stop, "PAUSE", 0.0)
        for _ in range(3):
            asked = await ask(2)
            await told.get()
        may_end.set()
        await asyncio.gather(*asked)
        assert not accepted.stops
        assert not accepted.stopping
