"""A `stop` that is accepted after a `start` leaves nothing running, whatever the start waits for, over any hops."""

import asyncio
import random
from collections.abc import Callable
from contextlib import AsyncExitStack
from itertools import pairwise
from typing import Any, Final

import pytest

from openrois.adapter import Component, command, parameter
from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.session.session import EngineHost
from openrois.transport.memory import MemoryStream
from tests.support.wire import Application, adapter_leg, application

SEEDS: Final = 200
ARM, HAND = "robot/arm", "robot/hand"


class Limb(Component, authority="Test", function="actuation"):
    """Moves until it is stopped, and takes its time to end."""

    speed: int = parameter(0)

    def __init__(self, name: str, pause: Callable[[], Any]) -> None:
        super().__init__(name)
        self.moving = 0
        self.moves = asyncio.Event()
        self._pause = pause

    @command
    async def start(self) -> None:
        self.moving += 1
        self.moves.set()
        try:
            await asyncio.Event().wait()
        finally:
            self.moving -= 1
            await self._pause()

    @command
    async def stop(self) -> None:
        await self._pause()

    @command
    async def stretch(self) -> None:
        await self._pause()


class Stage:
    """An application before a gateway, with an adapter behind it or behind one more gateway; all dawdle by `seed`."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.arm, self.hand = Limb("arm", self.pause), Limb("hand", self.pause)
        self.beside: list[str] = []
        """Ids of what is in sequences beside the starts."""
        self.slow: set[MemoryStream] = set()
        """Ends of connections over which something took its time to come."""
        self._ids = 0

    async def pause(self, _seconds: float = 0.0) -> None:
        for _ in range(self.random.randrange(8)):
            await asyncio.sleep(0)

    def unit(self, command_type: str, ref: str = ARM, delay: int = 0) -> dict[str, Any]:
        self._ids += 1
        named = {"component_ref": ref, "command_type": command_type, "command_id": f"{command_type}-{self._ids}"}
        more: dict[str, Any] = {"delay_time": delay} if delay else {}
        if command_type == "set_parameter":
            more["arguments"] = [{"name": "speed", "data_type_ref": "int", "value": "3"}]
        return {**named, **more}

    def sequence(self) -> tuple[list[Any], str]:
        """A sequence that starts the arm sooner or later, and the id of the command that does."""
        setting, start, delayed = self.unit("set_parameter"), self.unit("start"), self.unit("start", delay=5)
        stretch = self.unit("stretch", HAND)
        choices: tuple[tuple[list[Any], dict[str, Any]], ...] = (
            ([start], start),
            ([setting, start], start),
            ([delayed], delayed),
            ([stretch, start], start),
            ([setting, stretch, delayed], delayed),
            ([{"command_list": [stretch, start]}], start),
            ([{"command_list": [start], "delay_time": 2}], start),
            ([{"command_list": [stretch, setting]}, start], start),
        )
        items, starting = self.random.choice(choices)
        units = [unit for item in items for unit in item.get("command_list", [item])]
        self.beside += [each["command_id"] for each in units if each is not starting]
        return items, starting["command_id"]


async def deployed(stage: Stage, stack: AsyncExitStack) -> tuple[Application, list[EngineHost]]:
    async def host(engine: Engine) -> EngineHost:
        return EngineHost(engine, await stack.enter_async_context(TaskScope()), sleep=stage.pause)

    hosts = [await host(Engine("gateway"))]
    if stage.random.random() < 0.5:
        hosts.append(await host(Engine("fleet")))
    robot = Engine("robot")
    await robot.attach(LocalRegistry("robot", (stage.arm, stage.hand)))
    hosts.append(await host(robot))
    for above, below in reversed(tuple(pairwise(hosts))):
        await stack.enter_async_context(adapter_leg(above, below))
    return await stack.enter_async_context(application(hosts[0])), hosts


async def ended(app: Application, *command_ids: str) -> dict[str, str]:
    found: dict[str, str] = {}
    while not found.keys() >= set(command_ids):
        told = await app.next("rois.command.completed")
        assert told["command_id"] not in found
        found[told["command_id"]] = told["status"]
    return found


@pytest.mark.parametrize("block", range(8))
async def test_nothing_runs_after_a_stop_whatever_the_order(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    receive = MemoryStream.receive
    for seed in range(block, SEEDS, 8):
        stage = Stage(seed)

        async def dawdle(stream: MemoryStream, stage: Stage = stage) -> str:
            text = await receive(stream)
            stage.slow.add(stream)
            await stage.pause()
            return text

        # A session takes it when it begins.
        monkeypatch.setattr(MemoryStream, "receive", dawdle)
        async with asyncio.timeout(10), AsyncExitStack() as stack:
            app, hosts = await deployed(stage, stack)
            for ref in (ARM, HAND):
                assert (await app.ask("rois.command.bind", component_ref=ref))["return_code"] == "OK"
            begun = []
            for _ in range(stage.random.randrange(1, 3)):
                items, start = stage.sequence()
                begun.append(start)
                app.session.post("rois.command.execute", {"command_unit_list": items})
                if stage.random.random() < 0.3:
                    await stage.pause()
            stop = stage.unit("stop")
            app.session.post("rois.command.execute", {"command_unit_list": [stop]})
            statuses = await ended(app, stop["command_id"], *begun, *stage.beside)
            assert len(stage.slow) == 2 * len(hosts)
            assert statuses[stop["command_id"]] == "OK", seed
            assert {statuses[start] for start in begun} == {"ABORT"}, (seed, statuses)
            assert stage.arm.moving == 0, seed
            assert not any(host.pending.of(ref) for host in hosts for ref in (ARM, HAND)), seed


async def test_a_start_after_the_stop_runs() -> None:
    stage = Stage(0)
    async with asyncio.timeout(10), AsyncExitStack() as stack:
        app, _ = await deployed(stage, stack)
        await app.ask("rois.command.bind", component_ref=ARM)
        first, stop, second = (
            [stage.unit("set_parameter"), stage.unit("start")],
            stage.unit("stop"),
            stage.unit("start"),
        )
        for units in (first, [stop], [second]):
            app.session.post("rois.command.execute", {"command_unit_list": units})
        statuses = await ended(app, first[1]["command_id"], stop["command_id"])
        assert statuses[first[1]["command_id"]] == "ABORT"
        await stage.arm.moves.wait()
        last = stage.unit("stop")
        app.session.post("rois.command.execute", {"command_unit_list": [last]})
        assert (await ended(app, second["command_id"], last["command_id"]))[second["command_id"]] == "ABORT"


async def test_a_stop_of_its_own_sequence_leaves_what_stands_after_it() -> None:
    stage = Stage(0)
    async with asyncio.timeout(10), AsyncExitStack() as stack:
        app, _ = await deployed(stage, stack)
        await app.ask("rois.command.bind", component_ref=ARM)
        units = [stage.unit("stop"), stage.unit("set_parameter"), stage.unit("start")]
        app.session.post("rois.command.execute", {"command_unit_list": units})
        await stage.arm.moves.wait()
        last = stage.unit("stop")
        app.session.post("rois.command.execute", {"command_unit_list": [last]})
        await ended(app, units[2]["command_id"], last["command_id"])
