"""The server's side of a WebSocket where the other side is at its worst. The rest is in `tests/conformance`."""

import asyncio
from typing import Any

import pytest
from aiohttp import WSMessage, WSMsgType

from openrois.gateway import socket as module
from openrois.gateway.socket import APPLICATION, ServerSocket, SocketProfile
from openrois.transport.stream import StreamClosed

QUICK = SocketProfile(max_message=1, ping_interval=0, ping_timeout=0.01)


class Response:
    """Stands in for aiohttp's: a connection that takes nothing in and says what the test wants."""

    def __init__(self) -> None:
        self.close_code: int | None = None
        self.closed: list[tuple[int, bytes]] = []
        self.incoming: asyncio.Queue[WSMessage] = asyncio.Queue()

    async def close(self, *, code: int, message: bytes) -> None:
        self.closed.append((code, message))
        await asyncio.Event().wait()

    async def send_str(self, _text: str) -> None:
        raise ConnectionResetError("gone")

    async def receive(self) -> WSMessage:
        return await self.incoming.get()


class Transport:
    def __init__(self) -> None:
        self.aborted = asyncio.Event()
        self.written: list[bytes] = []

    def is_closing(self) -> bool:
        return self.aborted.is_set()

    def write(self, data: bytes) -> None:
        self.written.append(data)

    def abort(self) -> None:
        self.aborted.set()


class Request:
    def __init__(self, transport: Transport | None) -> None:
        self.transport = transport


def server_socket(profile: SocketProfile = APPLICATION) -> tuple[ServerSocket, Response, Transport]:
    transport, response = Transport(), Response()
    request: Any = Request(transport)
    made = ServerSocket(request, profile)
    stand_in: Any = response
    made.response = stand_in
    return made, response, transport


async def test_close_does_not_wait_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_CLOSE_TIMEOUT", 0.005)
    made, response, transport = server_socket()
    async with asyncio.timeout(60):
        await made.close(1008, "日" * 100)
    assert transport.aborted.is_set()
    assert response.closed == [(1008, ("日" * 41).encode())]


async def test_abort_after_the_connection_is_gone() -> None:
    request: Any = Request(None)
    ServerSocket(request, APPLICATION).abort()


async def test_sending_into_a_broken_connection() -> None:
    made, _, _ = server_socket()
    with pytest.raises(StreamClosed) as raised:
        await made.send("x")
    assert raised.value.code == 1006


async def test_a_side_that_is_read_from_and_says_nothing_is_cut() -> None:
    made, _, transport = server_socket(QUICK)
    receiving = asyncio.ensure_future(made.receive())
    await asyncio.sleep(0)
    async with asyncio.timeout(60):
        await made.keep_alive()
    assert transport.aborted.is_set()
    assert transport.written == [b"\x89\x00"]
    receiving.cancel()


async def test_a_side_that_is_not_read_from_is_not_judged() -> None:
    made, response, transport = server_socket(QUICK)
    keeping = asyncio.ensure_future(made.keep_alive())
    for _ in range(20):
        await asyncio.sleep(0)
    assert not transport.aborted.is_set()
    response.incoming.put_nowait(WSMessage(WSMsgType.TEXT, "x", None))
    assert await made.receive() == "x"
    receiving = asyncio.ensure_future(made.receive())
    async with asyncio.timeout(60):
        await keeping
    assert transport.aborted.is_set()
    receiving.cancel()


async def test_what_ends_a_connection_is_told_with_its_code() -> None:
    made, response, _ = server_socket()
    response.close_code = 1001
    response.incoming.put_nowait(WSMessage(WSMsgType.CLOSE, 1001, "bye"))
    with pytest.raises(StreamClosed) as raised:
        await made.receive()
    assert (raised.value.code, raised.value.reason) == (1001, "bye")
