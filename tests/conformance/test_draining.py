"""A gateway that is stopped: commands come to their end, and every client learns when to come back."""

import asyncio
import re
from contextlib import AsyncExitStack

import pytest
from aiohttp import ClientSession
from websockets.exceptions import InvalidStatus

from openrois.gateway.server import Gateway
from tests.support import deployment
from tests.support.deployment import Adapter, Application, Robot, application, patience
from tests.support.session import settle

LAMP = "robot/lamp"


async def execute(app: Application, command_id: str, command_type: str = "start") -> tuple[str, str]:
    unit = {"component_ref": LAMP, "command_type": command_type, "command_id": command_id, "arguments": []}
    return await app.why("rois.command.execute", command_unit_list=[unit])


async def until_draining(gateway: Gateway) -> None:
    async with ClientSession() as http, patience():
        while True:
            async with http.get(f"{gateway.url}readyz") as ready:
                if ready.status == 503:
                    assert (await ready.json())["lacking"] == ["time: it is draining"]
                    return


@pytest.fixture
async def busy(app: Application) -> Application:
    await app.ask("openrois.hello", version="1")
    await app.code("rois.command.bind", component_ref=LAMP)
    assert await execute(app, "running") == ("OK", "")
    return app


async def closed(app: Application) -> tuple[int, str]:
    async with patience():
        await app.socket.wait_closed()
    return app.socket.close_code or 0, app.socket.close_reason or ""


async def test_what_runs_ends_and_no_connection_is_admitted_meanwhile(
    gateway: Gateway, adapter: Adapter, busy: Application, robot: Robot
) -> None:
    async with patience():
        await robot.lamp.glowing.wait()
    draining = asyncio.ensure_future(gateway.drain())
    await until_draining(gateway)
    for path in ("", "adapter"):
        with pytest.raises(InvalidStatus) as refused:
            async with application(gateway, path):
                pass
        assert refused.value.response.status_code == 503
        assert refused.value.response.headers["Retry-After"] == "2"
    why = "the gateway is about to restart, and begins nothing new"
    assert await execute(busy, "new", "switch") == ("OUT_OF_RESOURCES", why)
    assert await busy.code("rois.query.query", query_type="brightness") == "OK"
    robot.lamp.may_end.set()
    assert await busy.completed("running") == {"running": "OK"}
    code, reason = await closed(busy)
    assert code == 1012
    assert re.fullmatch(r"retry_after=2\.\d\d", reason)
    await draining
    assert adapter.dialling is not None


async def test_a_stop_gets_through(gateway: Gateway, busy: Application, robot: Robot) -> None:
    async with patience():
        await robot.lamp.glowing.wait()
    draining = asyncio.ensure_future(gateway.drain())
    await until_draining(gateway)
    assert await execute(busy, "stop", "stop") == ("OK", "")
    assert await busy.completed("running", "stop") == {"running": "ABORT", "stop": "OK"}
    assert (await closed(busy))[0] == 1012
    await draining


async def test_what_does_not_end_is_handed_back(stack: AsyncExitStack, robot: Robot) -> None:
    gateway = await stack.enter_async_context(deployment.gateway(drain=0.01))
    await stack.enter_async_context(deployment.adapter(gateway, *robot.parts()))
    app = await stack.enter_async_context(application(gateway))
    await app.ask("openrois.hello", version="1")
    await app.code("rois.command.bind", component_ref=LAMP)
    later = {"component_ref": LAMP, "command_type": "switch", "command_id": "later", "arguments": []}
    now = later | {"command_type": "start", "command_id": "now"}
    assert await app.code("rois.command.execute", command_unit_list=[now, later]) == "OK"
    async with patience():
        await gateway.drain()
    assert await app.completed("now", "later") == {"now": "ABORT", "later": "ABORT"}
    assert app.reasons == dict.fromkeys(("now", "later"), "the gateway is about to restart")
    assert (await closed(app))[0] == 1012
    assert not robot.lamp.glowing.is_set()


async def test_an_idle_gateway_stops_at_once_and_adapters_are_asked_back_first(
    gateway: Gateway, adapter: Adapter, app: Application, other: Application, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", "openrois.adapter.dialer")
    async with patience():
        await gateway.drain()
        for each in (app, other):
            code, reason = await closed(each)
            assert code == 1012
            assert 2 <= float(reason.removeprefix("retry_after=")) <= 2.01
        assert adapter.dialling is not None
        await deployment.until(gateway.engine, lambda ids: "robot" not in ids)
        while "the gateway is gone" not in caplog.text:
            await settle()
    asked = re.search(r"closed with 1012 retry_after=(\S+)", caplog.text)
    assert asked is not None
    assert 0.25 <= float(asked[1]) <= 1
