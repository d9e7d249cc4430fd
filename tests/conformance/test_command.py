"""The Command interface: sequences whose component changes hands, lost adapters, and very many commands."""

import asyncio
from contextlib import AsyncExitStack
from typing import Any

import pytest

from openrois.commands.history import MAX_RUNNING
from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot

LAMP, BELL, DOOR = "robot/lamp", "robot/bell", "robot/door"


def unit(command_id: str, command: str = "switch", ref: str = LAMP, **more: Any) -> dict[str, Any]:
    return {"component_ref": ref, "command_type": command, "command_id": command_id, **more}


def value(name: str, text: str) -> dict[str, str]:
    return {"name": name, "data_type_ref": "whatever", "value": text}


async def execute(app: Application, *units: dict[str, Any]) -> str:
    return await app.code("rois.command.execute", command_unit_list=list(units))


async def bind(app: Application, ref: str = LAMP) -> str:
    return await app.code("rois.command.bind", component_ref=ref)


class TestParameters:
    async def test_set_parameter_as_a_command_unit(self, app: Application, robot: Robot) -> None:
        await bind(app)
        assert await execute(app, unit("p", "set_parameter", arguments=[value("colour", "red")])) == "OK"
        assert await app.completed("p") == {"p": "OK"}
        assert robot.lamp.parameters["colour"] == "red"
        assert await execute(app, unit("q", "set_parameter", BELL)) == "UNSUPPORTED"


class TestExecute:
    async def test_units_are_checked_one_after_another(self, app: Application) -> None:
        await bind(app)
        bad = unit("a", arguments=[value("times", "many")])
        assert await execute(app, bad, unit("b", "explode")) == "BAD_PARAMETER"
        assert await execute(app, unit("a"), unit("b", "explode")) == "UNSUPPORTED"


async def test_a_bug_in_between_still_completes(
    app: Application, gateway: Gateway, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gateway.engine, "invoke", lambda *_asked: 1 / 0)
    assert await execute(app, unit("o", "open", DOOR), unit("p", "open", DOOR)) == "OK"
    assert await app.completed("o", "p") == {"o": "ERROR", "p": "ABORT"}


class TestAdapterLost:
    async def test_it_comes_back_unbound(self, app: Application, other: Application, adapter: Adapter) -> None:
        await bind(app)
        await adapter.stop()
        await adapter.start()
        assert await execute(app, unit("c")) == "OUT_OF_RESOURCES"
        assert await bind(other) == "OK"


async def test_what_is_left_of_a_sequence_stays_off_what_another_has_bound(
    app: Application, other: Application, robot: Robot
) -> None:
    robot.door.may_answer.clear()
    await bind(app)
    assert await execute(app, unit("open", "open", DOOR), unit("late"), unit("last")) == "OK"
    await app.ask("rois.command.release", component_ref=LAMP)
    assert await bind(other) == "OK"
    robot.door.may_answer.set()
    assert await app.completed("open", "late", "last") == {"open": "OK", "late": "OUT_OF_RESOURCES", "last": "ABORT"}
    assert robot.lamp.total == 0


async def test_the_rest_of_a_sequence_runs_on_a_free_component(app: Application, robot: Robot) -> None:
    robot.door.may_answer.clear()
    await bind(app)
    assert await execute(app, unit("open", "open", DOOR), unit("late")) == "OK"
    await app.ask("rois.command.release", component_ref=LAMP)
    robot.door.may_answer.set()
    assert await app.completed("open", "late") == {"open": "OK", "late": "OK"}


class TestVeryMany:
    """As many commands as one application may have at a time."""

    IDS = tuple(str(number) for number in range(MAX_RUNNING))

    async def begin(self, app: Application) -> None:
        for first in range(0, MAX_RUNNING, MAX_RUNNING // 2):
            units = [unit(command_id, "open", DOOR) for command_id in self.IDS[first : first + MAX_RUNNING // 2]]
            assert await execute(app, {"command_list": units}) == "OK"

    @pytest.mark.long
    async def test_their_adapter_stays_however_many_start_at_once(self, robot: Robot, stack: AsyncExitStack) -> None:
        # How long a busy machine takes for so many is not what it is about.
        gateway = await stack.enter_async_context(deployment.gateway(adapter_timeout=60))
        await stack.enter_async_context(deployment.adapter(gateway, *robot.parts()))
        other = await stack.enter_async_context(deployment.application(gateway))
        robot.door.may_answer.clear()
        apps = [await stack.enter_async_context(deployment.application(gateway)) for _ in range(4)]
        await asyncio.gather(*(self.begin(app) for app in apps))
        robot.door.may_answer.set()
        for app in apps:
            assert set((await app.completed(*self.IDS)).values()) == {"OK"}
        assert await other.settled() == []

    async def test_others_are_served(self, app: Application, other: Application, robot: Robot) -> None:
        robot.door.may_answer.clear()
        await self.begin(app)
        assert await bind(other) == "OK"
        assert await execute(other, unit("mine")) == "OK"
        assert await other.completed("mine") == {"mine": "OK"}

    async def test_their_application_stays_when_they_end_at_once(
        self, app: Application, adapter: Adapter, robot: Robot
    ) -> None:
        robot.door.may_answer.clear()
        await self.begin(app)
        async with deployment.patience():
            await robot.door.asked.wait()
        await adapter.stop()
        assert set((await app.completed(*self.IDS)).values()) == {"ERROR"}
        assert await app.code("rois.system.connect") == "OK"
