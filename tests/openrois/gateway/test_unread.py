"""What waits unread on many connections of one subject, and what it costs others."""

import asyncio
import json
import re
import socket
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path
from urllib.parse import urlsplit

import aiohttp
from websockets.exceptions import ConnectionClosed

from openrois.engine.registry import LocalRegistry
from tests.support import deployment
from tests.support.components import Lamp
from tests.support.guarded import Guarded, fresh, guarded

UNREAD = 1 << 20
PROFILE = json.dumps({"jsonrpc": "2.0", "id": 1, "method": "rois.system.get_profile", "params": {"condition": ""}})


async def figure(gateway: Guarded, name: str) -> float:
    async with aiohttp.ClientSession() as http, http.get(gateway.gateway.metrics) as answer:
        found = re.search(rf"^{name} (\S+)$", await answer.text(), re.MULTILINE)
    assert found is not None
    return float(found[1])


@asynccontextmanager
async def deaf(gateway: Guarded, subject: str) -> AsyncIterator[asyncio.Task[None]]:
    """A connection that asks without an end, and reads nothing; gives the task that ends when it is cut."""
    url = urlsplit(gateway.gateway.url)
    near = socket.socket()
    near.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    near.setblocking(False)
    await asyncio.get_running_loop().sock_connect(near, (url.hostname, url.port))
    async with gateway.dial(fresh(sub=subject), sock=near, max_queue=1, ping_interval=None, close_timeout=0) as socket_:

        async def ask() -> None:
            with suppress(ConnectionClosed):
                while True:
                    await socket_.send(PROFILE)
                    await asyncio.sleep(0)

        asking = asyncio.ensure_future(ask())
        try:
            yield asking
        finally:
            asking.cancel()


async def test_connections_that_read_nothing_leave_the_room_of_others(tmp_path: Path) -> None:
    async with (
        guarded(tmp_path, unread=UNREAD, metrics="0") as gateway,
        AsyncExitStack() as stack,
    ):
        await gateway.gateway.engine.attach(LocalRegistry("house", [Lamp(f"lamp_{number}") for number in range(100)]))
        honest = await stack.enter_async_context(gateway.dial(fresh(sub="honest"), max_size=None))
        asking = [await stack.enter_async_context(deaf(gateway, "greedy")) for _ in range(4)]
        async with deployment.patience():
            for _ in range(5):
                await honest.send(PROFILE)
                assert "result" in json.loads(await honest.recv())
            await asyncio.wait(asking, return_when=asyncio.FIRST_COMPLETED)
        assert await figure(gateway, "openrois_gateway_unread_cuts_total") >= 1
        assert await figure(gateway, "openrois_gateway_unread_characters") <= UNREAD
        assert await figure(gateway, "openrois_gateway_unread_characters_limit") == UNREAD
        await honest.send(PROFILE)
        assert "result" in json.loads(await honest.recv())
