"""Connections without a request header, or with half of one, and what they cost others."""

import asyncio
import ssl
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import aiohttp
import pytest
from aiohttp import web

from openrois.gateway.server import Gateway
from openrois.http_limits import header_timeout as module
from tests.support import deployment
from tests.support.certificates import Authority

UPGRADE = (
    b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n"
)

CLIENT_HELLO_BEGIN = bytes.fromhex("16030102000100")
"""The header of a record of TLS with a `ClientHello` of 512 bytes, and nothing of it."""

Settings = dict[str, Any]


@pytest.fixture(params=["plain", "tls"])
def encryption(request: pytest.FixtureRequest, tmp_path: Path) -> Settings:
    """The settings of a gateway without and with TLS."""
    if request.param == "plain":
        return {}
    cert, key = Authority(tmp_path).issue()
    return {"tls_cert": cert, "tls_key": key}


def context(gateway: Gateway) -> ssl.SSLContext | None:
    """How to come to a gateway: whether it is the right one does not matter here."""
    if not gateway.url.startswith("https"):
        return None
    trusting = ssl.create_default_context()
    trusting.check_hostname, trusting.verify_mode = False, ssl.CERT_NONE
    return trusting


class Knock:
    """A connection to a gateway."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader = reader
        self._writer = writer

    async def say(self, text: bytes) -> None:
        self._writer.write(text)
        await self._writer.drain()

    async def hear(self) -> bytes:
        """Return what comes next; nothing at the end."""
        return await self._reader.read(4096)

    async def cut(self) -> bytes:
        """Read until the gateway has ended the connection, and return what it said."""
        heard = b""
        with suppress(ConnectionError):
            async with deployment.patience():
                while part := await self.hear():
                    heard += part
        return heard

    @property
    def is_cut(self) -> bool:
        """Whether the gateway has ended the connection, as far as is known here."""
        return self._reader.at_eof() or self._reader.exception() is not None


@asynccontextmanager
async def knocking(gateway: Gateway, said: bytes, *, raw: bool = False) -> AsyncIterator[Knock]:
    """A connection on which no more is said than this; a raw one does no TLS."""
    url = urlsplit(gateway.url)
    reader, writer = await asyncio.open_connection(url.hostname, url.port, ssl=None if raw else context(gateway))
    knock = Knock(reader, writer)
    try:
        await knock.say(said)
        yield knock
    finally:
        writer.transport.abort()


def application(gateway: Gateway) -> Any:
    return deployment.application(gateway, ssl=context(gateway))


@pytest.mark.parametrize("said", [b"", b"G", UPGRADE])
async def test_half_a_handshake_is_cut(monkeypatch: pytest.MonkeyPatch, said: bytes, encryption: Settings) -> None:
    async with deployment.gateway(**encryption) as gateway, application(gateway) as app:
        monkeypatch.setattr(module, "HEAD_TIMEOUT", 0.2)
        # On a busy machine the handshake of TLS before it may be what takes too long.
        with suppress(ConnectionError):
            async with knocking(gateway, said) as near:
                assert await near.cut() == b""
        assert await app.code("rois.system.connect") == "OK"


async def test_half_a_request_after_a_whole_one_is_cut(monkeypatch: pytest.MonkeyPatch, encryption: Settings) -> None:
    async with deployment.gateway(**encryption) as gateway, knocking(gateway, b"") as near:
        monkeypatch.setattr(module, "HEAD_TIMEOUT", 0.05)
        await near.say(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\nGET /he")
        heard = await near.cut()
    assert heard.startswith(b"HTTP/1.1 200")
    assert heard.count(b"HTTP/1.1") == 1


@pytest.mark.parametrize("said", [b"", CLIENT_HELLO_BEGIN])
async def test_half_a_handshake_of_tls_is_cut(monkeypatch: pytest.MonkeyPatch, said: bytes, tmp_path: Path) -> None:
    monkeypatch.setattr(module, "HEAD_TIMEOUT", 0.05)
    cert, key = Authority(tmp_path).issue()
    async with (
        deployment.gateway(tls_cert=cert, tls_key=key) as gateway,
        knocking(gateway, said, raw=True) as near,
    ):
        assert await near.cut() == b""


async def test_of_too_many_the_oldest_is_cut(encryption: Settings) -> None:
    async with deployment.gateway(silent=3, silent_per_address=3, **encryption) as gateway, AsyncExitStack() as stack:
        waiting = [await stack.enter_async_context(knocking(gateway, b"GET /")) for _ in range(3)]
        async with application(gateway) as app:
            assert await app.code("rois.system.connect") == "OK"
            assert await waiting[0].cut() == b""
        assert not any(near.is_cut for near in waiting[1:])


@pytest.mark.parametrize("said", [b"", CLIENT_HELLO_BEGIN])
async def test_of_too_many_handshakes_of_tls_the_oldest_is_cut(said: bytes, tmp_path: Path) -> None:
    cert, key = Authority(tmp_path).issue()
    settings: Settings = {"tls_cert": cert, "tls_key": key, "silent": 3, "silent_per_address": 3}
    async with deployment.gateway(**settings) as gateway, AsyncExitStack() as stack:
        waiting = [await stack.enter_async_context(knocking(gateway, said, raw=True)) for _ in range(3)]
        async with application(gateway) as app:
            assert await app.code("rois.system.connect") == "OK"
            assert await waiting[0].cut() == b""
        assert not any(near.is_cut for near in waiting[1:])


async def never_asked(_request: web.BaseRequest) -> web.StreamResponse:
    raise NotImplementedError


async def test_of_too_many_from_one_address_its_oldest_is_cut() -> None:
    cut: list[str] = []
    header_timeouts = module.HeaderTimeouts(lambda _reason: None, 4, 2)

    class Silent(module.Connection):
        def __init__(self, name: str, address: str) -> None:
            super().__init__(web.Server(never_asked), header_timeouts, address, loop=asyncio.get_running_loop())
            self.name = name

        def abort(self) -> bool:
            cut.append(self.name)
            return True

    for name, address in (("a1", "A"), ("b1", "B"), ("b2", "B"), ("b3", "B"), ("c1", "C"), ("c2", "C")):
        header_timeouts.join(Silent(name, address))
    # The third of B cuts the first of B, though that of A is older; with the fifth of all the oldest is A's.
    assert cut == ["b1", "a1"]
    assert header_timeouts.silent == 4
    for each in tuple(header_timeouts._open):
        header_timeouts.leave(each)
    assert (header_timeouts.silent, header_timeouts.open, +header_timeouts._of_address) == (0, 0, {})


@pytest.mark.parametrize(
    "said",
    [
        b"GET / HTTP/1.1\r\nHost: localhost\r\nx: ",
        b"no request at all",
        UPGRADE + b"\r\n",
        b"GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000000\r\n\r\n",
    ],
)
async def test_a_flood_in_the_place_of_a_head_is_cut(taken: list[int], said: bytes, encryption: Settings) -> None:
    async with deployment.gateway(**encryption) as gateway:
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


async def test_after_a_refused_upgrade_heads_are_bounded_still(taken: list[int], encryption: Settings) -> None:
    refused = UPGRADE.replace(b"Connection: Upgrade\r\n", b"") + b"\r\n"
    async with deployment.gateway(**encryption) as gateway, knocking(gateway, refused) as near:
        assert (await near.hear()).startswith(b"HTTP/1.1 400")
        with suppress(ConnectionError):
            await near.say(b"GET / HTTP/1.1\r\n" + b"x: y\r\n" * 2**20)
        await near.cut()
        assert near.is_cut
    assert sum(taken) <= 2 * module.MAX_HEAD


async def flood(gateway: Gateway, said: bytes) -> None:
    """Say this, and go on with what means nothing until the connection is cut."""
    async with knocking(gateway, said) as near:
        with suppress(ConnectionError):
            for _ in range(1024):
                await near.say(bytes(64 * 1024))
        await near.cut()
        assert near.is_cut


async def test_a_closed_connection_is_not_waited_for(monkeypatch: pytest.MonkeyPatch, encryption: Settings) -> None:
    monkeypatch.setattr(module, "HEAD_TIMEOUT", 3600.0)
    async with deployment.gateway(metrics="0", **encryption) as gateway, aiohttp.ClientSession() as http:

        async def silent(count: int, opened: int) -> None:
            async with deployment.patience():
                told = ""
                while (
                    f"\nopenrois_gateway_silent_connections {count}" not in told
                    or f"\nopenrois_gateway_open_connections {opened}" not in told
                ):
                    async with http.get(gateway.metrics) as answer:
                        told = await answer.text()

        async with knocking(gateway, b"GET /"), knocking(gateway, b"", raw=True), application(gateway):
            await silent(2, 3)
        await silent(0, 0)
