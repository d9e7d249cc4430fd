"""Gateways that say nothing, anything, too much or too often to an application in C#, and that leave at every stage."""

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from http import HTTPStatus
from typing import Any, Final

import pytest
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from tests.sdk_csharp.conftest import Start
from tests.sdk_csharp.test_operations import attached
from tests.support.demo import free_port
from tests.support.deployment import gateway
from tests.support.fleet import everything

pytestmark = pytest.mark.timeout(120)

ANYWHERE: Final = "127.0.0.1"
GREETING: Final = ("rois.system.connect", "openrois.hello", "openrois.lease.token")
PLAIN: Final[dict[str, dict[str, Any]]] = {
    "openrois.hello": {"extensions": ["openrois.lease"]},
    "openrois.lease.token": {"token": "t", "grace_ms": 10000},
    "rois.event.subscribe": {"subscribe_id": "s"},
    "rois.command.search": {"component_ref_list": ["robot/lamp"]},
}

NO_MESSAGES: Final = (
    "",
    "{",
    "no JSON",
    "[]",
    "null",
    "[" * 200,
    '[{"jsonrpc":"2.0","method":"rois.system.profile_changed"}]',
    '{"jsonrpc":"1.0","method":"rois.system.profile_changed"}',
    '{"jsonrpc":"2.0","id":1,"result":{}}',
    '{"jsonrpc":"2.0","id":99999999999999999999999,"result":{}}',
    '{"jsonrpc":"2.0","id":1,"error":{"code":99999999999999999999,"message":"x"}}',
    '{"jsonrpc":"2.0","id":null,"error":7}',
    '{"jsonrpc":"2.0","method":"m","params":{"a":"\\uZZZZ"}}',
    '{"jsonrpc":"2.0","method":"rois.command.completed","params":{"command_id":null,"status":"OK"}}',
    '{"jsonrpc":"2.0","method":"rois.command.completed","params":{"command_id":"none of its own","status":"OK"}}',
    '{"jsonrpc":"2.0","method":"rois.event.notify_event","params":{"subscribe_id":7}}',
    '{"jsonrpc":"2.0","method":"rois.event.notify_event","params":{"subscribe_id":"none","event_id":"e","event_type":"x"}}',
    '{"jsonrpc":"2.0","method":"openrois.reason","params":{"reason":"\\ud800","request_id":1e400}}',
    '{"jsonrpc":"2.0","method":"openrois.lease.changed","params":{"lease":[]}}',
    '{"jsonrpc":"2.0","method":"signaling.offer","params":{"sdp":[]}}',
    '{"jsonrpc":"2.0","method":"openrois.events_dropped","params":{"count":1e400}}',
    '{"jsonrpc":"2.0","id":"theirs","method":"rois.system.connect","params":{}}',
)
"""What comes in place of messages, or is one of which nothing may come."""


def told(number: int, on: str = "true") -> str:
    """An event of the lamp."""
    results = [{"name": "on", "data_type_ref": "bool", "value": on}]
    params = {"event_id": f"e{number}", "event_type": "switched", "subscribe_id": "s", "results": results}
    return json.dumps({"jsonrpc": "2.0", "method": "rois.event.notify_event", "params": params})


class Gateway:
    """Answers plainly, and does what a test wants beside that.

    Attributes:
        url: where it is.
        asked: what came on any connection, and was no answer.
        connections: those that are open, in their order.
        before: is awaited with each request before it is answered; it may close the connection.
    """

    def __init__(self) -> None:
        self.url = ""
        self.asked: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.connections: list[ServerConnection] = []
        self.before: Callable[[ServerConnection, str], Awaitable[None]] | None = None
        self.held: set[str] = set()

    async def serve(self, connection: ServerConnection) -> None:
        """Serve one connection."""
        self.connections.append(connection)
        try:
            async for text in connection:
                message = json.loads(text)
                if "method" in message:
                    await self._take(connection, message)
        except ConnectionClosed:
            pass
        finally:
            self.connections.remove(connection)

    async def _take(self, connection: ServerConnection, request: dict[str, Any]) -> None:
        if self.before is not None:
            await self.before(connection, request["method"])
        if request["params"].get("condition") not in self.held:
            await self.answer(request, connection)
        self.asked.put_nowait(request)

    async def answer(self, request: dict[str, Any], connection: ServerConnection | None = None) -> None:
        """Answer a request, on the newest connection unless one is given."""
        result = {"return_code": "OK", **PLAIN.get(request["method"], {})}
        await self.say(json.dumps({"jsonrpc": "2.0", "id": request["id"], "result": result}), connection)

    async def say(self, text: str | bytes, connection: ServerConnection | None = None) -> None:
        """Send anything."""
        await (connection or self.connections[-1]).send(text)

    async def until(self, method: str, condition: str | None = None) -> dict[str, Any]:
        """Return the next request of a method."""
        async with asyncio.timeout(30):
            while True:
                request = await self.asked.get()
                if request["method"] == method and condition in (None, request["params"].get("condition")):
                    return request


@asynccontextmanager
async def strange(greets: int = len(GREETING)) -> AsyncIterator[Gateway]:
    """Serve a gateway that answers so many requests of the greeting, and closes with 1011 instead of the next."""
    here = Gateway()

    async def leave(connection: ServerConnection, method: str) -> None:
        if greets < len(GREETING) and method == GREETING[greets]:
            await connection.close(1011, "out of order")

    here.before = leave
    async with serve(here.serve, ANYWHERE, 0, max_size=None) as server:
        here.url = f"ws://{ANYWHERE}:{server.sockets[0].getsockname()[1]}/"
        yield here


@asynccontextmanager
async def silent() -> AsyncIterator[str]:
    """Listen, and say nothing to those that connect."""

    async def keep(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.read()
        writer.close()

    async with await asyncio.start_server(keep, ANYWHERE, 0) as server:
        yield f"ws://{ANYWHERE}:{server.sockets[0].getsockname()[1]}/"


async def test_what_does_not_become_a_connection_says_so_in_a_sentence(start: Start) -> None:
    async def refuse(_connection: ServerConnection, _request: Request) -> Response:
        return _connection.respond(HTTPStatus.SERVICE_UNAVAILABLE, "full")

    async with AsyncExitStack() as stack:
        urls = [await stack.enter_async_context(silent())]
        for stage in range(len(GREETING)):
            urls.append((await stack.enter_async_context(strange(stage))).url)
        stalled = await stack.enter_async_context(strange())
        stalled.before = lambda connection, _method: connection.wait_closed()
        urls.append(stalled.url)
        full = await stack.enter_async_context(serve(Gateway().serve, ANYWHERE, 0, process_request=refuse))
        urls.append(f"ws://{ANYWHERE}:{full.sockets[0].getsockname()[1]}/")
        urls.append(f"ws://{ANYWHERE}:{free_port()}/")
        app = await stack.enter_async_context(start("barred", " ".join(urls)))
        said = await app.says("failed")
        await app.ends()
    late = "the gateway did not answer within 3000 ms"
    assert said[0] == late
    for method, each in zip(GREETING, said[1:4], strict=True):
        assert each == (
            f"no connection to the gateway: {method}: the connection ended before the answer came (out of order (1011))"
        )
    assert said[4] == late
    # Mono does not say the status, so that the sentence has what helps against each.
    assert said[5].startswith(f"what listens at {urls[5]} refuses this application")
    assert "set ClientOptions.Token" in said[5]
    assert said[6] == f"no connection to {urls[6]}: Connection refused"


async def test_whatever_a_gateway_says_the_client_goes_on(start: Start) -> None:
    async with strange() as here, start("steadfast", here.url) as app:
        await app.says("ready")
        for number, text in enumerate(NO_MESSAGES):
            await here.say(text)
            await here.say(told(number))
            assert await app.says("switched") is True
        await here.say(told(100, "perhaps"))
        # A message of another kind, or one that is too long, ends the connection, and the next one begins.
        for wrong, reason in ((b"bytes", "1003"), (" " * (17 << 20), "1009")):
            await here.say(wrong)
            assert reason in await app.says("lost")
            await app.says("restored")
            await here.say(told(101))
            assert await app.says("switched") is True
        here.held.add("gives up")
        await app.go_on()
        given_up = await here.until("rois.command.search", "gives up")
        await app.go_on()
        assert await app.says("gave up") == "TaskCanceledException"
        await here.answer(given_up)
        twice = await here.until("rois.command.search", "twice")
        await here.answer(twice)
        assert await app.says("found") == ["robot/lamp"]
        assert await app.says("again") == ["robot/lamp"]
        assert await app.says("unreadable") == 1
        assert await app.says("failures") == []
        await app.ends()


async def test_clients_that_come_and_go_leave_nothing_behind(start: Start) -> None:
    times = 60
    async with (
        gateway() as running,
        attached(running, everything()),
        start("frugal", running.url, TIMES=str(times)) as app,
    ):
        assert await app.says("other") is True
        # The pool has threads of its own, as many as it thinks.
        assert await app.says("files") < times / 4
        assert await app.says("threads") < times / 4
        await app.ends()
