"""Connections that say nothing, or only half of it, and what they cost those who do."""

import asyncio
import socket
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from urllib.parse import urlsplit

import aiohttp
import pytest
from aiohttp import web

from openrois import heads as module
from openrois.gateway.server import Gateway
from tests.support import deployment

UPGRADE = (
    b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
)


@asynccontextmanager
async def knocking(gateway: Gateway, said: bytes) -> AsyncIterator[socket.socket]:
    """A connection on which no more is said than this."""
    loop = asyncio.get_running_loop()
    with socket.socket() as near:
        near.setblocking(False)
        url = urlsplit(gateway.url)
        await loop.sock_connect(near, (url.hostname, url.port))
        await loop.sock_sendall(near, said)
        yield near


async def cut(near: socket.socket) -> bytes:
    """Read until the gateway has ended the connection, and return what it said."""
    heard = b""
    try:
        async with asyncio.timeout(5):
            while part := await asyncio.get_running_loop().sock_recv(near, 4096):
                heard += part
    except ConnectionResetError:
        pass
    return heard


@pytest.mark.parametrize("said", [b"", b"G", UPGRADE, b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\nGET /he"])
async def test_half_a_handshake_is_cut(monkeypatch: pytest.MonkeyPatch, said: bytes) -> None:
    monkeypatch.setattr(module, "HEAD_TIMEOUT", 0.05)
    async with deployment.gateway() as gateway, deployment.application(gateway) as app:
        async with knocking(gateway, said) as near:
            heard = await cut(near)
            assert heard.startswith(b"HTTP/1.1 200") if b"healthz" in said else heard == b""
        assert await app.code("rois.system.connect") == "OK"


async def test_of_too_many_the_oldest_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_HEADS", 3)
    async with deployment.gateway() as gateway, AsyncExitStack() as stack:
        waiting = [await stack.enter_async_context(knocking(gateway, b"GET /")) for _ in range(3)]
        async with deployment.application(gateway) as app:
            assert await app.code("rois.system.connect") == "OK"
            assert await cut(waiting[0]) == b""
        for near in waiting[1:]:
            with pytest.raises(BlockingIOError):
                near.recv(1)


@pytest.mark.parametrize(
    "said",
    [
        b"GET / HTTP/1.1\r\nHost: localhost\r\nx: ",
        b"no request at all",
        UPGRADE + b"\r\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\n",
    ],
)
async def test_a_flood_in_the_place_of_a_head_is_cut(taken: list[int], said: bytes) -> None:
    async with deployment.gateway() as gateway:
        with pytest.raises((ConnectionResetError, BrokenPipeError)):
            await flood(gateway, said)
    # Each of two heads may have so much: one that is answered, and what comes behind it.
    assert sum(taken) <= 2 * module.MAX_HEAD


@pytest.fixture
def taken(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Of each read, how many bytes the server library was given."""
    sizes: list[int] = []
    take = web.RequestHandler.data_received

    def count(protocol: web.RequestHandler, data: bytes) -> None:
        sizes.append(len(data))
        take(protocol, data)

    monkeypatch.setattr(web.RequestHandler, "data_received", count)
    return sizes


async def test_after_a_refused_upgrade_heads_are_bounded_still(taken: list[int]) -> None:
    refused = UPGRADE.replace(b"Connection: Upgrade\r\n", b"") + b"\r\n"
    async with deployment.gateway() as gateway, knocking(gateway, refused) as near:
        loop = asyncio.get_running_loop()
        assert (await loop.sock_recv(near, 4096)).startswith(b"HTTP/1.1 400")
        with pytest.raises((ConnectionResetError, BrokenPipeError)):
            await loop.sock_sendall(near, b"GET / HTTP/1.1\r\n" + b"x: y\r\n" * 2**20)
    assert sum(taken) <= 2 * module.MAX_HEAD


async def flood(gateway: Gateway, said: bytes) -> None:
    """Say this, and go on with what means nothing."""
    async with knocking(gateway, said) as near:
        for _ in range(1024):
            await asyncio.get_running_loop().sock_sendall(near, bytes(64 * 1024))


async def test_who_is_gone_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "HEAD_TIMEOUT", 3600.0)
    async with deployment.gateway(metrics="0") as gateway, aiohttp.ClientSession() as http:

        async def silent(count: int) -> None:
            async with asyncio.timeout(deployment.PATIENCE):
                told = ""
                while f"\nopenrois_gateway_silent_connections {count}" not in told:
                    async with http.get(gateway.metrics) as answer:
                        told = await answer.text()

        async with knocking(gateway, b"GET /"), knocking(gateway, b""):
            await silent(2)
        await silent(0)
