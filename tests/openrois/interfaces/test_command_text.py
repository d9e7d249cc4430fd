"""What is kept of unfinished commands: one subject has a share of it, and gives it back however they end."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack
from dataclasses import dataclass, field
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.auth.principal import LOCAL
from openrois.commands import quota
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.session.session import EngineHost
from tests.support.authorization import PATIENCE, Place, Wire, principal
from tests.support.components import Lamp
from tests.support.deployment import Door
from tests.support.wire import adapter_leg

DOOR, LAMP = "robot/door", "robot/lamp"
SHARE = 100_000
LONG = "x" * 40_000


@dataclass
class Scene:
    """A gateway with a robot, and three connections: two of one subject, one of another."""

    host: EngineHost
    door: Door
    robot: Callable[[], Awaitable[None]]
    turn: asyncio.Event = field(default_factory=asyncio.Event)
    wires: list[Wire] = field(default_factory=list)

    async def nothing_is_left(self) -> None:
        """Wait until every command has ended, and check that nothing is counted any more."""
        async with asyncio.timeout(PATIENCE):
            while self.host.commands.taken:
                await self.wires[2].code("rois.system.connect", {})
        assert self.host.commands.text == 0
        assert not self.host.commands._shares


@pytest.fixture
async def scene(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Scene]:
    monkeypatch.setattr(quota, "MAX_TEXT_OF_SUBJECT", SHARE)
    door, turn = Door(), asyncio.Event()

    async def sleep(_seconds: float) -> None:
        await turn.wait()

    async with AsyncExitStack() as stack:
        host = EngineHost(Engine("gateway"), await stack.enter_async_context(TaskScope()), sleep=sleep)
        below = Engine("robot")
        await below.attach(LocalRegistry("robot", (door, Lamp())))
        far = await stack.enter_async_context(adapter_leg(host, below))
        made = Scene(host, door, far.close, turn)
        here = Place(host, {})
        for subject in ("ann", "ann", "bob"):
            who = principal("operator", "*", subject=subject)
            made.wires.append(await stack.enter_async_context(here.application(who)))
            assert await made.wires[-1].code("openrois.hello", {"version": "1"}) == "OK"
        yield made
        turn.set()
        door.may_answer.set()


def unit(command_id: str, command_type: str = "open", **more: Any) -> dict[str, Any]:
    ref = DOOR if command_type == "open" else LAMP
    return {"component_ref": ref, "command_type": command_type, "command_id": command_id, **more}


def long(command_id: str, command_type: str = "open", **more: Any) -> dict[str, Any]:
    name = "how" if command_type == "open" else "note"
    arguments = [{"name": name, "data_type_ref": "string", "value": LONG}]
    return unit(command_id, command_type, arguments=arguments, **more)


async def execute(wire: Wire, *units: dict[str, Any]) -> str | int:
    return await wire.code("rois.command.execute", {"command_unit_list": units})


async def test_another_subject_is_served_while_one_has_used_its_share(scene: Scene) -> None:
    first, second, other = scene.wires
    assert await first.code("rois.command.bind", {"component_ref": LAMP}) == "OK"
    for command_id in ("a", "b"):
        assert await execute(first, long(command_id, delay_time=1)) == "OK"
    kept = scene.host.commands.text
    assert 2 * len(LONG) < kept < SHARE
    assert await execute(second, unit("before"), long("c", delay_time=1)) == "OUT_OF_RESOURCES"
    reason = str((await second.until("openrois.reason"))["reason"])
    assert f"{SHARE} bytes" in reason
    assert "subject" in reason
    colour = [{"name": "colour", "data_type_ref": "string", "value": LONG}]
    setting = {"component_ref": LAMP, "parameters": colour}
    assert await first.code("rois.command.set_parameter", setting) == "OUT_OF_RESOURCES"
    assert (scene.host.commands.taken, scene.host.commands.text, scene.door.opened) == (2, kept, [])
    assert await execute(other, long("a")) == "OK"
    assert await other.completed("a") == "OK"
    assert await execute(first, unit("stop", "stop")) == "OK"
    assert await first.completed("stop") == "OK"
    assert await first.code("rois.command.release", {"component_ref": LAMP}) == "OK"
    assert await first.code("rois.system.disconnect", {}) == "OK"
    scene.turn.set()
    await scene.nothing_is_left()
    assert await execute(second, long("c")) == "OK"


async def test_stops_are_accepted_when_the_share_is_used_up(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    app = scene.wires[0]
    assert await app.code("rois.command.bind", {"component_ref": LAMP}) == "OK"
    assert await execute(app, long("a", delay_time=1)) == "OK"
    monkeypatch.setattr(scene.host.commands._shares["ann"], "most_text", scene.host.commands.text)
    assert await execute(app, unit("b")) == "OUT_OF_RESOURCES"
    assert await execute(app, unit("stop", "stop")) == "OK"
    assert await app.completed("stop") == "OK"


async def test_without_authentication_one_has_what_there_is(scene: Scene) -> None:
    async with Place(scene.host, {}).application(LOCAL) as app:
        for command_id in ("a", "b", "c"):
            assert await execute(app, long(command_id, delay_time=1)) == "OK"
        scene.turn.set()
        await scene.nothing_is_left()


async def test_a_sequence_is_kept_until_its_last_command_has_ended(scene: Scene) -> None:
    app = scene.wires[0]
    assert await execute(app, long("a"), unit("b", delay_time=1)) == "OK"
    assert await app.completed("a") == "OK"
    assert scene.host.commands.text > len(LONG)
    scene.turn.set()
    assert await app.completed("b") == "OK"
    await scene.nothing_is_left()


async def failed(scene: Scene) -> None:
    scene.wires[0].frames.clear()
    assert await execute(scene.wires[0], unit("f", "fail"), long("skipped", "switch")) == "OK"
    assert await scene.wires[0].completed("skipped") == "ABORT"
    scene.turn.set()


async def stopped(scene: Scene) -> None:
    assert await scene.wires[0].code("openrois.stop_all", {"component_ref": LAMP}) == "OK"
    assert await scene.wires[0].completed("lamp") == "ABORT"
    scene.turn.set()


async def disconnected(scene: Scene) -> None:
    assert await scene.wires[0].code("rois.system.disconnect", {}) == "OK"
    scene.turn.set()


async def lost(scene: Scene) -> None:
    await scene.wires[0].stream.close(1006)
    scene.turn.set()


async def adapter_lost(scene: Scene) -> None:
    scene.door.may_answer.clear()
    assert await execute(scene.wires[0], long("hangs")) == "OK"
    await scene.door.asked.wait()
    await scene.robot()
    assert await scene.wires[0].completed("hangs") == "ERROR"
    scene.turn.set()


@pytest.mark.parametrize("way", [failed, stopped, disconnected, lost, adapter_lost])
async def test_it_is_given_back_however_commands_end(scene: Scene, way: Callable[[Scene], Awaitable[None]]) -> None:
    app = scene.wires[0]
    assert await app.code("rois.command.bind", {"component_ref": LAMP}) == "OK"
    assert await execute(app, long("lamp", "switch", delay_time=1)) == "OK"
    assert scene.host.commands.text > len(LONG)
    await way(scene)
    await scene.nothing_is_left()


async def test_it_is_given_back_when_the_application_goes_before_the_reply(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    noted = asyncio.Event()

    async def hang(*_arguments: object) -> None:
        noted.set()
        await asyncio.Event().wait()

    monkeypatch.setattr(scene.host.journal, "accepted", hang)
    asking = asyncio.ensure_future(execute(scene.wires[0], long("a")))
    await noted.wait()
    assert scene.host.commands.text > len(LONG)
    await scene.wires[0].stream.close(1006)
    await asyncio.wait({asking})
    assert asking.exception() is not None
    await scene.nothing_is_left()
