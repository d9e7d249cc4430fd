"""What is kept of a sequence: nothing once all of its commands have ended, whatever delays it still names."""

from collections.abc import AsyncIterator
from contextlib import AsyncExitStack
from typing import Any

import pytest

from openrois.aio.tasks import TaskScope
from openrois.engine.engine import Engine
from openrois.engine.registry import LocalRegistry
from openrois.session.session import EngineHost
from openrois.types.messages import MAX_DELAY
from tests.support.components import Lamp
from tests.support.deployment import forever
from tests.support.wire import Application, application

LAMP = "robot/lamp"
EMPTY = {"command_list": [], "delay_time": MAX_DELAY}


def unit(command_type: str, command_id: str, **more: Any) -> dict[str, Any]:
    return {"component_ref": LAMP, "command_type": command_type, "command_id": command_id, **more}


async def no_delay_ends(_seconds: float) -> None:
    await forever()


@pytest.fixture
async def host() -> AsyncIterator[EngineHost]:
    async with AsyncExitStack() as stack:
        engine = Engine("gateway")
        await engine.attach(LocalRegistry("robot", (Lamp(),)))
        yield EngineHost(engine, await stack.enter_async_context(TaskScope()), sleep=no_delay_ends)


@pytest.fixture
async def app(host: EngineHost) -> AsyncIterator[Application]:
    async with application(host) as connected:
        assert (await connected.ask("rois.command.bind", component_ref=LAMP))["return_code"] == "OK"
        yield connected


async def idle(host: EngineHost, app: Application) -> bool:
    """Tell whether nothing goes on behind the calls."""
    for _ in range(5):
        await app.ask("rois.system.connect")
    return len(host.tasks) == 0 and host.commands.taken == 0 and host.commands.text == 0


async def test_delays_behind_the_last_command_are_not_waited_for(host: EngineHost, app: Application) -> None:
    for number in range(3):
        sequence = [unit("switch", f"{number}"), EMPTY, EMPTY]
        assert (await app.ask("rois.command.execute", command_unit_list=sequence))["return_code"] == "OK"
        told = await app.next("rois.command.completed")
        assert told == {"command_id": f"{number}", "status": "OK"}
    assert await idle(host, app)


async def test_commands_that_were_stopped_before_their_turn_leave_nothing_behind(
    host: EngineHost, app: Application
) -> None:
    delayed = unit("start", "b", delay_time=MAX_DELAY)
    ways: tuple[tuple[str, dict[str, Any]], ...] = (
        ("openrois.stop_all", {"component_ref": LAMP}),
        ("rois.command.execute", {"command_unit_list": [unit("stop", "c")]}),
    )
    for number, (method, params) in enumerate(ways):
        sequences: list[list[Any]] = [
            [{**delayed, "command_id": f"{number} alone"}],
            [{"command_list": [{**delayed, "command_id": f"{number} beside"}]}, EMPTY],
            [EMPTY, unit("start", f"{number} behind")],
        ]
        for sequence in sequences:
            assert (await app.ask("rois.command.execute", command_unit_list=sequence))["return_code"] == "OK"
        assert (await app.ask(method, **params))["return_code"] == "OK"
        ended = [await app.next("rois.command.completed") for _ in range(3 + number)]
        assert sorted(each["status"] for each in ended) == ["ABORT"] * 3 + ["OK"] * number
        assert len({each["command_id"] for each in ended}) == 3 + number
        assert await idle(host, app)
