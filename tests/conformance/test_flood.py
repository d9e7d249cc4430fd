"""An application that asks for more than it may: its answers, and requests that still get through."""

import asyncio
import json
from typing import Any

import pytest

from openrois.commands.history import MAX_RUNNING, STOP_RESERVE
from openrois.gateway.applications import REQUESTS_AT_ONCE
from openrois.gateway.server import Gateway
from openrois.jsonrpc.request_queue import MAX_RUNNING_REQUESTS
from tests.support.deployment import Application, Robot

LAMP = "robot/lamp"
DOOR = "robot/door"
WAITING = 10_000


def request(number: int | str, method: str, **params: Any) -> str:
    return json.dumps({"jsonrpc": "2.0", "id": number, "method": method, "params": params})


def unit(command_type: str, command_id: str, component_ref: str = LAMP) -> dict[str, Any]:
    return {"component_ref": component_ref, "command_type": command_type, "command_id": command_id, "arguments": []}


@pytest.fixture
def hanging(gateway: Gateway, monkeypatch: pytest.MonkeyPatch) -> asyncio.Event:
    """Queries that take until the event is set."""
    answering = asyncio.Event()

    async def query(_component_ref: str, _query_type: str) -> tuple[()]:
        await answering.wait()
        return ()

    monkeypatch.setattr(gateway.engine, "query", query)
    return answering


async def flood(app: Application) -> None:
    """Ask what is not answered yet, ten thousand times."""
    for number in range(WAITING):
        await app.send(request(number, "rois.query.query", query_type="view"))


async def codes(app: Application, count: int) -> dict[Any, str]:
    """Return the return codes of so many answers, by their requests."""
    found: dict[Any, str] = {}
    while len(found) < count:
        message = await app.hear()
        if "result" in message:
            assert message["id"] not in found, "a request was answered twice"
            found[message["id"]] = message["result"]["return_code"]
    return found


async def test_stop_release_and_disconnect_pass_ten_thousand_requests(
    app: Application, robot: Robot, hanging: asyncio.Event
) -> None:
    await app.ask("openrois.hello", version="1", extensions=[])
    await app.code("rois.command.bind", component_ref=LAMP)
    await app.ask("rois.command.execute", command_unit_list=[unit("start", "begin")])
    await robot.lamp.glowing.wait()
    await flood(app)
    await app.send(request("late", "rois.command.execute", command_unit_list=[unit("start", "too late")]))
    assert await app.code("openrois.stop_all") == "OK"
    assert not robot.lamp.glowing.is_set()
    assert (await app.completed("begin")) == {"begin": "ABORT"}
    for method, params in (
        ("rois.command.execute", {"command_unit_list": [unit("stop", "end")]}),
        ("rois.command.release", {"component_ref": LAMP}),
        ("rois.system.disconnect", {}),
    ):
        assert await app.code(method, **params) == "OK"
    # What was asked before the stop and waited is refused; queries are not what a stop is about.
    assert (await app.answer("late"))["result"]["return_code"] == "OUT_OF_RESOURCES"
    assert app.reasons["late"] == "it waited when openrois.stop_all came"
    assert not any(number in app.answers for number in range(WAITING))
    hanging.set()
    answered = await codes(app, WAITING)
    assert len(answered) == WAITING
    assert not robot.lamp.glowing.is_set()


async def test_a_flood_is_refused_with_retry_after(
    app: Application, other: Application, robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The clock of the limit stands still: what is at hand is all there is.
    await app.ask("openrois.hello", version="1", extensions=[])
    monkeypatch.setattr("openrois.aio.rate.RateLimit._fill", lambda _limit: None)
    for number in range(REQUESTS_AT_ONCE):
        await app.send(request(number, "rois.system.connect"))
    answered = await codes(app, REQUESTS_AT_ONCE)
    refused = [number for number, code in answered.items() if code == "OUT_OF_RESOURCES"]
    assert refused == list(range(REQUESTS_AT_ONCE - len(refused), REQUESTS_AT_ONCE))
    assert 0 < len(refused) < 10
    assert await app.code("openrois.stop_all") == "OK"
    assert (await app.refused("unknown.method"))["code"] == -32000
    assert await app.why("rois.query.query", query_type="brightness") == (
        "OUT_OF_RESOURCES",
        "too many requests a second; retry_after=0.000",
    )
    assert await other.code("rois.query.query", query_type="brightness") == "OK"


async def test_requests_that_wait_are_bounded(
    app: Application, hanging: asyncio.Event, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("openrois.jsonrpc.request_queue.MAX_WAITING_REQUESTS", 40)
    asked = MAX_RUNNING_REQUESTS + 40
    for number in range(asked + 2):
        await app.send(request(number, "rois.query.query", query_type="view"))
    assert await codes(app, 2) == {asked: "OUT_OF_RESOURCES", asked + 1: "OUT_OF_RESOURCES"}
    hanging.set()
    assert len(await codes(app, asked)) == asked


async def test_a_stop_is_accepted_when_no_other_command_is(app: Application, robot: Robot) -> None:
    robot.door.may_answer.clear()
    await app.code("rois.command.bind", component_ref=LAMP)
    for number in range(MAX_RUNNING // 256):
        units = [unit("open", f"{number}.{part}", DOOR) for part in range(256)]
        assert await app.code("rois.command.execute", command_unit_list=[{"command_list": units}]) == "OK"
    one_more = [unit("open", "more", DOOR)]
    assert await app.code("rois.command.execute", command_unit_list=one_more) == "OUT_OF_RESOURCES"
    for number in range(STOP_RESERVE // 2):
        assert await app.code("rois.command.execute", command_unit_list=[unit("stop", f"stop {number}")]) == "OK"
    mixed = [unit("stop", "a"), unit("open", "b", DOOR)]
    assert await app.code("rois.command.execute", command_unit_list=mixed) == "OUT_OF_RESOURCES"
