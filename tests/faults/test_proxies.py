"""F42: a proxy that cuts what is idle, one that is started again, and a name that is not resolved for a while."""

import asyncio
import socket
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from openrois.client import BindingRestored, Client, Connected, Disconnected
from tests.support.ground import ground
from tests.support.invariants import PATIENCE
from tests.support.proxies import IDLE, proxy
from tests.support.seeds import SOME, lasting

pytestmark = pytest.mark.usefixtures("haproxy")


@pytest.mark.parametrize("seed", lasting(0))
async def test_f42_pings_keep_alive_what_a_proxy_takes_for_idle(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async with (
        ground(seed, tmp_path, caplog, quick=True) as place,
        proxy(place.gateway.url, folder=tmp_path) as between,
    ):
        await place.robot(url=between.url)
        app = await place.stack.enter_async_context(place.book.witness(between.url))
        assert await app.bind() == "OK"
        # Longer than the proxy waits; that time is its own.
        await asyncio.sleep(IDLE * (2 + place.chance.random()))
        assert not app.gone.is_set()
        assert await app.execute("c") == "OK"
        place.lamp.may_end.set()
        assert await app.end_of("c") == "OK"


async def test_f42_the_proxy_of_these_tests_is_impatient(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    async with ground(0, tmp_path, caplog) as place, proxy(place.gateway.url, folder=tmp_path) as between:
        # The gateway's own pings come every four seconds.
        idle = await connect(between.url.replace("http", "ws"), proxy=None, ping_interval=None)
        with pytest.raises(ConnectionClosed):
            await asyncio.wait_for(idle.recv(), PATIENCE)


@pytest.mark.parametrize("seed", SOME)
async def test_f42_a_proxy_that_is_started_again(
    seed: int, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    resolve, nameless = socket.getaddrinfo, asyncio.Event()

    def unresolved(host: Any, *arguments: Any, **options: Any) -> Any:
        if host == "gateway.test":
            if nameless.is_set():
                raise socket.gaierror(socket.EAI_AGAIN, "Temporary failure in name resolution")
            host = "127.0.0.1"
        return resolve(host, *arguments, **options)

    monkeypatch.setattr(socket, "getaddrinfo", unresolved)
    async with (
        ground(seed, tmp_path, caplog, quick=True, allow_hosts=("gateway.test",)) as place,
        proxy(place.gateway.url, folder=tmp_path) as between,
    ):
        await place.robot(url=between.url)
        url = between.url.replace("http", "ws").replace("127.0.0.1", "gateway.test")
        async with Client(url) as client:
            lamp = client.component("robot/lamp")
            gone, restored = client.notices(Disconnected), client.notices(BindingRestored)
            connected = client.notices(Connected)
            async with lamp.bound():
                if seed % 2:
                    nameless.set()
                await between.kill()
                await anext(gone)
                await place.attached(there=False)
                await between.start()
                nameless.clear()
                await place.attached()
                await anext(restored)
                await anext(connected)
                place.lamp.may_end.set()
                await lamp.command("start")
                # The client keeps no book of what it asks.
                place.book.accepted += 1
