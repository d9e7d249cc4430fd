"""Connections that say nothing, or only half of it, and what they cost those who do."""

import asyncio
import socket
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from urllib.parse import urlsplit

import pytest

from openrois.gateway import heads as module
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
