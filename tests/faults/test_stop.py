"""STOP where nothing else gets through: an adapter that has all the requests it takes, and more that wait."""

import asyncio
from pathlib import Path
from typing import Any

import pytest

from openrois.commands import stop
from openrois.component.authoring.marks import command, query
from openrois.component.component import Component
from openrois.engine.registry import MAX_QUERIES
from openrois.jsonrpc.request_queue import MAX_RUNNING_REQUESTS
from tests.support.components import Lamp
from tests.support.ground import ground, turns
from tests.support.seeds import SOME

LAMP, OTHER = "robot/lamp", "robot/other"


class Pensive(Component, authority="Test", function="sensing"):
    """Is asked, and thinks."""

    asked = 0
    may_answer = asyncio.Event()

    @query(result="answer")
    async def think(self) -> int:
        """Answer when the test allows it."""
        Pensive.asked += 1
        await self.may_answer.wait()
        return 42


class Motor(Component, authority="Test", function="actuation"):
    """Turns until it is stopped."""

    turning = False

    @command
    async def start(self) -> None:
        """Turn."""
        self.turning = True
        await asyncio.Event().wait()

    @command
    async def stop(self) -> None:
        """Turn no more."""
        self.turning = False


@pytest.mark.parametrize("seed", SOME)
async def test_stop_passes_whatever_stands_before_an_adapter(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    # How fast this machine is does not matter here: behind the others it would have to wait for ever.
    monkeypatch.setattr(stop, "STOP_TIMEOUT", 10.0)
    monkeypatch.setattr(Pensive, "asked", 0)
    monkeypatch.setattr(Pensive, "may_answer", asyncio.Event())
    thinkers = [Pensive(f"thinker{number}") for number in range(MAX_RUNNING_REQUESTS // MAX_QUERIES)]
    motors = [Motor(f"motor{number}") for number in range(70)]
    async with ground(seed, tmp_path, caplog, longest=0.5) as place:
        await place.robot(place.lamp, Lamp("other"), *motors, *thinkers)
        holder, crowd = await place.witness(extended=True), await place.witness(extended=True)
        assert await holder.bind() == "OK"
        assert await holder.execute("glows") == "OK"
        await place.running(1)
        for motor in motors:
            assert await holder.bind(f"robot/{motor.name}") == "OK"
            assert await holder.execute(f"turns {motor.name}", "start", f"robot/{motor.name}") == "OK"
        await place.running(1 + len(motors))
        thinking = [await think(crowd, number % len(thinkers)) for number in range(MAX_RUNNING_REQUESTS)]
        async with asyncio.timeout(10):
            while Pensive.asked < MAX_RUNNING_REQUESTS or not all(motor.turning for motor in motors):
                await turns(place.chance)
        # These wait behind them, in the adapter: it runs so many at a time for its gateway, of whatever application.
        condition = f"component_ref = '{OTHER}'"
        waiting = [
            await holder.begin("rois.query.query", query_type="brightness", condition=condition)
            for _ in range(place.chance.randint(50, 150))
        ]
        late = [f"late{number}" for number in range(place.chance.randint(1, 5))]
        for command_id in late:
            assert await holder.execute(command_id, place.chance.choice(["start", "switch"])) == "OK"
        await turns(place.chance, 50)
        if place.chance.random() < 0.5:
            answer = await holder.ask("openrois.stop_all", engine_id="robot")
            assert answer["return_code"] == "OK"
            assert set(answer["stopped"]) == {LAMP, OTHER, *(f"robot/{motor.name}" for motor in motors)}
        else:
            assert await holder.execute("halt", "stop") == "OK"
            assert await holder.end_of("halt") == "OK"
            for motor in motors:
                assert await holder.execute(f"halt {motor.name}", "stop", f"robot/{motor.name}") == "OK"
        for command_id in ("glows", *(f"turns {motor.name}" for motor in motors)):
            assert await holder.end_of(command_id) == "ABORT"
        assert not place.lamp.glowing.is_set()
        assert not any(motor.turning for motor in motors)
        # All others still stand where they stood: nothing but the stop has passed.
        assert not any(each.done() for each in (*thinking, *waiting))
        # What was asked of the component before the stop, and waited, does not begin behind it.
        for command_id in late:
            assert await holder.end_of(command_id) in ("ABORT", "OUT_OF_RESOURCES")
        assert place.lamp.total == 0
        Pensive.may_answer.set()
        async with asyncio.timeout(10):
            codes = [(await each)["result"]["return_code"] for each in (*thinking, *waiting)]
        assert set(codes) == {"OK"}
        assert not place.lamp.glowing.is_set()
        assert place.lamp.total == 0


async def think(crowd: Any, number: int) -> "asyncio.Future[dict[str, Any]]":
    """Ask what takes until it may be answered."""
    condition = f"component_ref = 'robot/thinker{number}'"
    future: asyncio.Future[dict[str, Any]] = await crowd.begin(
        "rois.query.query", query_type="think", condition=condition
    )
    return future
