"""The moving components as an application at a gateway has them: every command ends once, and as RoIS says."""

import asyncio
import itertools
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from openrois_body.messages import Thing

from openrois.testing import memory_gateway
from openrois.transport.stream import MessageStream
from tests.support.walker import STEP, Walking


class Application:
    """Raw messages: what was answered, and every notification there was."""

    def __init__(self, stream: MessageStream) -> None:
        self._stream = stream
        self._ids = itertools.count(1)
        self._executed: set[str] = set()
        self.notified: list[tuple[str, dict[str, Any]]] = []

    async def hear(self) -> dict[str, Any]:
        async with asyncio.timeout(60):
            message: dict[str, Any] = json.loads(await self._stream.receive())
        if "method" in message:
            self.notified.append((message["method"].rpartition(".")[2], message["params"]))
        return message

    async def ask(self, method: str, **params: Any) -> dict[str, Any]:
        number = next(self._ids)
        await self._stream.send(json.dumps({"jsonrpc": "2.0", "id": number, "method": method, "params": params}))
        while True:
            message = await self.hear()
            if message.get("id") == number:
                assert message["result"]["return_code"] == "OK", message
                result: dict[str, Any] = message["result"]
                return result

    async def set(self, ref: str, **values: str) -> None:
        parameters = [{"name": name, "data_type_ref": "", "value": value} for name, value in values.items()]
        await self.ask("rois.command.set_parameter", component_ref=ref, parameters=parameters)

    async def execute(self, ref: str, command: str, command_id: str) -> None:
        self._executed.add(command_id)
        unit = {"component_ref": ref, "command_type": command, "command_id": command_id}
        await self.ask("rois.command.execute", command_unit_list=[unit])

    @property
    def completed(self) -> list[tuple[str, str]]:
        """How the commands ended that were executed; setting parameters is one, too, with an id of the gateway's."""
        ended = [(each["command_id"], each["status"]) for what, each in self.notified if what == "completed"]
        return [each for each in ended if each[0] in self._executed]


class Stage(Walking):
    app: Application

    async def until_completed(self, number: int = 1, seconds: float = 30) -> None:
        """Let everything live until so many commands have ended, and a little longer."""
        for _ in range(round(seconds / STEP)):
            await self.run(STEP)
            if await self._ended(number):
                break
        await self.run(1)
        await self._ended(number)

    async def _ended(self, number: int) -> bool:
        await self.app.ask("rois.command.search", condition="")
        return len(self.app.completed) >= number


@asynccontextmanager
async def behind_a_gateway(*names: str) -> AsyncIterator[Stage]:
    stage = Stage()
    async with (
        memory_gateway(*stage.components, engine_id="avatar") as gateway,
        gateway.dial() as stream,
    ):
        stage.app = Application(stream)
        await stage.app.ask("rois.system.connect")
        for name in names:
            await stage.app.ask("rois.command.bind", component_ref=f"avatar/{name}")
        yield stage


async def test_a_route_tells_its_targets_and_is_completed_once() -> None:
    async with behind_a_gateway("navigation") as stage:
        await stage.app.ask("rois.event.subscribe", event_type="reached_target")
        await stage.app.set("avatar/navigation", target_positions='["0.5,0","0.5,0.5"]')
        await stage.app.execute("avatar/navigation", "start", "go")
        await stage.until_completed()
        assert [what for what, _ in stage.app.notified] == ["completed", "notify_event", "notify_event", "completed"]
        assert stage.app.completed == [("go", "OK")]


@pytest.mark.parametrize(
    ("name", "values", "act", "status"),
    [
        ("navigation", {"target_positions": '["4,0"]', "time_limit": "1000"}, None, "TIMEOUT"),
        ("navigation", {"target_positions": '["4,0"]'}, "stop", "ABORT"),
        ("navigation", {"target_positions": '["4,0"]'}, "lose", "ERROR"),
        ("navigation", {"target_positions": '["4,0"]'}, "refuse", "ERROR"),
        ("move", {"line": "[300,90]"}, None, "OK"),
        ("move", {"line": "[3000,0]"}, "stop", "ABORT"),
        ("move", {"line": "[3000,0]"}, "drive", "ABORT"),
        ("move", {"curve": "[1000,90]"}, "lose", "ERROR"),
        ("follower", {"target_object_ref": "anna", "distance": "500", "time_limit": "1000"}, None, "TIMEOUT"),
        ("follower", {"target_object_ref": "anna", "distance": "500"}, "stop", "ABORT"),
        ("follower", {"target_object_ref": "anna", "distance": "500"}, "vanish", "ERROR"),
        ("follower", {"target_object_ref": "anna", "distance": "500"}, "lose", "ERROR"),
    ],
)
async def test_every_end_is_told_once(name: str, values: dict[str, str], act: str | None, status: str) -> None:
    async with behind_a_gateway(name) as stage:
        stage.populate(Thing("anna", "person", 3, 0))
        await stage.app.set(f"avatar/{name}", **values)
        await stage.app.execute(f"avatar/{name}", "start", "go")
        await stage.run(0.2)
        match act:
            case "stop":
                await stage.app.execute(f"avatar/{name}", "stop", "halt")
            case "lose":
                stage.lose()
            case "refuse":
                stage.engine.refuse()
            case "drive":
                stage.legs.drive(0.1, 0, 0)
            case "vanish":
                stage.populate()
        await stage.until_completed(2 if act == "stop" else 1)
        assert [each for each in stage.app.completed if each[0] == "go"] == [("go", status)]
        assert not stage.engine.moves or not stage.engine.connected


async def test_of_two_motions_the_second_one_goes() -> None:
    async with behind_a_gateway("navigation", "move") as stage:
        await stage.app.set("avatar/navigation", target_positions='["4,0"]')
        await stage.app.set("avatar/move", line="[-300,0]")
        await stage.app.execute("avatar/navigation", "start", "first")
        await stage.run(0.2)
        await stage.app.execute("avatar/move", "start", "second")
        await stage.until_completed(2)
        assert stage.app.completed == [("first", "ABORT"), ("second", "OK")]
