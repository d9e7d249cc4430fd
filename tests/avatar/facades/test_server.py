"""The WebSocket server for a game engine: one at a time, from this machine, robust against its messages."""

import asyncio
import json
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field

import pytest
from openrois_avatar.facades.messages.reading import MESSAGE_LIMIT
from openrois_avatar.facades.server import FacadeUnavailable, StreamerServer
from openrois_avatar.facades.streamer import Heard, Offered
from openrois_avatar.facades.unreal import UnrealStreamer
from openrois_avatar.options.link_options import facade_address
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.typing import Origin, Subprotocol

PATIENCE = 5.0


@dataclass
class Place:
    """A server that listens, and the messages it has reported."""

    server: StreamerServer
    url: str
    heard: asyncio.Queue[Heard] = field(default_factory=asyncio.Queue)
    lost: asyncio.Queue[str] = field(default_factory=asyncio.Queue)

    @asynccontextmanager
    async def greeted(self) -> AsyncIterator[ClientConnection]:
        """A streamer that has sent its id."""
        async with connect(self.url) as socket, asyncio.timeout(PATIENCE):
            assert [await said(socket), await said(socket)] == ["config", "identify"]
            await socket.send('{"type": "endpointId", "id": "U"}')
            assert await said(socket) == "endpointIdConfirm"
            assert self.server.streamer is not None
            yield socket


async def said(socket: ClientConnection) -> str:
    return str(json.loads(await socket.recv())["type"])


@asynccontextmanager
async def place(secret: str = "") -> AsyncIterator[Place]:
    heard: asyncio.Queue[Heard] = asyncio.Queue()
    lost: asyncio.Queue[str] = asyncio.Queue()
    server = StreamerServer(UnrealStreamer, heard.put_nowait, lost.put_nowait, secret, time.monotonic)
    async with server.listening("127.0.0.1", 0) as url:
        yield Place(server, url, heard, lost)


async def test_a_streamer_is_greeted_heard_and_missed() -> None:
    async with place() as here:
        assert here.server.streamer is None
        async with here.greeted() as socket:
            assert here.server.streamer is not None
            here.server.streamer.invite("7", ())
            assert await said(socket) == "playerConnected"
            await socket.send('{"type": "offer", "playerId": "7", "sdp": "v=0"}')
            assert await here.heard.get() == Offered("7", "v=0")
        async with asyncio.timeout(PATIENCE):
            assert await here.lost.get() == "it has closed the connection"
        assert here.server.streamer is None


async def test_second_streamer_is_refused_until_the_first_disconnects() -> None:
    async with place() as here:
        async with here.greeted() as socket:
            with pytest.raises(InvalidStatus, match="503"):
                await connect(here.url)
            await socket.send('{"type": "ping", "time": 1}')
            assert await said(socket) == "pong"
        await here.lost.get()
        async with here.greeted():
            pass


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        ("{", "no message with a type"),
        (b"\x00", "messages must be texts"),
        ('{"type": "offer"}', "offer: playerId"),
        ("x" * (MESSAGE_LIMIT + 1), None),
    ],
)
async def test_malformed_message_ends_the_connection_with_a_reason(message: str | bytes, reason: str | None) -> None:
    async with place() as here:
        async with here.greeted() as socket:
            await socket.send(message)
            with pytest.raises(ConnectionClosed) as closed:
                await socket.recv()
            if reason is not None:
                assert closed.value.rcvd is not None
                assert closed.value.rcvd.code == 1008
                assert reason in closed.value.rcvd.reason
        await here.lost.get()
        async with here.greeted():
            pass


async def test_a_flood_ends_the_connection() -> None:
    async with place() as here, here.greeted() as socket:
        with pytest.raises(ConnectionClosed) as closed:  # noqa: PT012
            for _ in range(4000):
                await socket.send('{"type": "stats"}')
            await socket.recv()
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.reason == "too many messages: at most 256 a second"


async def test_engine_that_does_not_read_is_disconnected() -> None:
    async with place() as here, here.greeted():
        assert here.server.streamer is not None
        for number in range(600):
            here.server.streamer.invite(str(number), ())
        assert await here.lost.get()


async def test_with_a_secret_the_path_must_be_it() -> None:
    async with place("s3cret/x") as here:
        for wrong in ("", "s3cret", "s3cret/y"):
            with pytest.raises(InvalidStatus, match="403"):
                await connect(here.url + wrong)
        for right in ("s3cret/x", "s3cret%2Fx"):
            async with connect(here.url + right) as socket:
                assert await said(socket) == "config"
            await here.lost.get()


async def test_pages_of_other_sites_are_refused() -> None:
    async with place() as here:
        for origin in ("https://example.org", "http://localhost.example.org", "http://[::"):
            with pytest.raises(InvalidStatus, match="403"):
                await connect(here.url, origin=Origin(origin))
        own = Origin("http://localhost:3000")
        async with connect(here.url, origin=own, subprotocols=[Subprotocol("ws")]) as socket:
            assert socket.subprotocol == "ws"


@pytest.mark.parametrize(("host", "status"), [("localhost", 426), ("rebound.example.org", 403)])
async def test_request_without_websocket_gets_an_explanation(host: str, status: int) -> None:
    async with place() as here:
        reader, writer = await asyncio.open_connection("127.0.0.1", int(here.url.rsplit(":", 1)[1].strip("/")))
        writer.write(f"GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n".encode())
        async with asyncio.timeout(PATIENCE):
            answer = await reader.read()
        writer.close()
        assert answer.startswith(f"HTTP/1.1 {status}".encode())
        assert here.server.streamer is None


async def test_a_port_that_is_taken_is_named() -> None:
    async with place() as here:
        port = int(here.url.rsplit(":", 1)[1].strip("/"))
        with pytest.raises(FacadeUnavailable, match=f"127.0.0.1:{port}"):
            async with here.server.listening("127.0.0.1", port):
                pass


async def test_a_streamer_that_is_still_there_at_the_end_is_told() -> None:
    async with place() as here:
        socket = await connect(here.url)
    with pytest.raises(ConnectionClosed) as closed:  # noqa: PT012
        while True:
            await socket.recv()
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1001


def test_an_address_is_a_loopback_host_and_a_port() -> None:
    assert facade_address("127.0.0.1:8888") == ("127.0.0.1", 8888)
    assert facade_address("[::1]:0") == ("::1", 0)
    assert facade_address("localhost:80") == ("localhost", 80)


@pytest.mark.parametrize("text", ["", "8888", "127.0.0.1", "127.0.0.1:x", "127.0.0.1:65536", "0.0.0.0:1", "host:1"])
def test_malformed_address_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"address|loopback"):
        facade_address(text)
