"""The server's side of a WebSocket where the other side is at its worst. The rest is in `tests/conformance`."""

import asyncio
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from aiohttp import WSMessage, WSMsgType

from openrois.gateway import socket as module
from openrois.gateway.socket import APPLICATION, WRITE_BUFFER, ServerSocket, SocketProfile
from openrois.gateway.stalling import STALL_TIMEOUT
from openrois.transport.stream import StreamClosed

QUICK = SocketProfile(max_message=1, ping_interval=0, ping_timeout=0.01)


class Response:
    """Stands in for aiohttp's: a connection that takes nothing in and says what the test wants."""

    def __init__(self) -> None:
        self.close_code: int | None = None
        self.closed: list[tuple[int, bytes]] = []
        self.incoming: asyncio.Queue[WSMessage] = asyncio.Queue()

    async def prepare(self, _request: object) -> None:
        pass

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
        self.wrote = asyncio.Event()
        self.taken: int | None = None
        """Bytes that the kernel has taken; None for all."""

    def get_write_buffer_size(self) -> int:
        return 0 if self.taken is None else sum(map(len, self.written)) - self.taken

    def is_closing(self) -> bool:
        return self.aborted.is_set()

    def write(self, data: bytes) -> None:
        self.written.append(data)
        self.wrote.set()

    def abort(self) -> None:
        self.aborted.set()

    def set_write_buffer_limits(self, *, high: int) -> None:
        self.high = high


class Request:
    def __init__(self, transport: Transport | None) -> None:
        self.transport = transport
        self.protocol = SimpleNamespace()


def server_socket(profile: SocketProfile = APPLICATION, **options: Any) -> tuple[ServerSocket, Response, Transport]:
    transport, response = Transport(), Response()
    request: Any = Request(transport)
    made = ServerSocket(request, profile, **options)
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
    assert [data[:2] for data in transport.written] == [b"\x89\x10"]
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


async def pinged(transport: Transport) -> bytes:
    """Wait for a ping, and return what it says."""
    async with asyncio.timeout(60):
        await transport.wrote.wait()
    transport.wrote.clear()
    return transport.written[-1][2:]


@pytest.mark.parametrize("answers", [lambda sent: b"", lambda sent: sent[:15], lambda sent: bytes(16)])
async def test_a_pong_that_does_not_say_what_its_ping_said_is_no_sign_of_life(
    answers: Callable[[bytes], bytes],
) -> None:
    reasons: list[str] = []
    made, response, transport = server_socket(QUICK, on_cut=reasons.append)
    receiving = asyncio.ensure_future(made.receive())
    keeping = asyncio.ensure_future(made.keep_alive())
    response.incoming.put_nowait(WSMessage(WSMsgType.PONG, answers(await pinged(transport)), None))
    async with asyncio.timeout(60):
        await keeping
    assert (transport.aborted.is_set(), len(transport.written), reasons) == (True, 1, ["no answer to a ping"])
    receiving.cancel()


async def test_a_pong_that_says_what_its_ping_said_is_a_sign_of_life() -> None:
    made, response, transport = server_socket(SocketProfile(max_message=1, ping_interval=0, ping_timeout=60))
    receiving = asyncio.ensure_future(made.receive())
    keeping = asyncio.ensure_future(made.keep_alive())
    said = set()
    for _ in range(3):
        said.add(await pinged(transport))
        response.incoming.put_nowait(WSMessage(WSMsgType.PONG, transport.written[-1][2:], None))
    assert len(said) == 3
    assert not transport.aborted.is_set()
    for task in (receiving, keeping):
        task.cancel()


async def test_a_side_that_takes_no_byte_for_too_long_is_cut_whatever_it_says() -> None:
    times, reasons = [0.0], list[str]()
    profile = SocketProfile(max_message=1, ping_interval=0, ping_timeout=60)
    made, response, transport = server_socket(profile, clock=lambda: times[-1], on_cut=reasons.append)
    transport.taken = 0
    keeping = asyncio.ensure_future(made.keep_alive())

    async def spoken(at: float) -> None:
        """Say something at this time, and wait until the next ping is due."""
        await pinged(transport)
        times.append(at)
        response.incoming.put_nowait(WSMessage(WSMsgType.TEXT, "x", None))
        await made.receive()

    await spoken(0.0)
    await spoken(STALL_TIMEOUT - 0.1)
    await pinged(transport)
    transport.wrote.set()
    # One byte is enough to begin anew.
    transport.taken = 1
    await spoken(STALL_TIMEOUT)
    await spoken(2 * STALL_TIMEOUT - 0.1)
    await spoken(2 * STALL_TIMEOUT)
    async with asyncio.timeout(60):
        await keeping
    assert (transport.aborted.is_set(), reasons) == (True, ["takes nothing in"])


async def test_little_waits_in_front_of_the_kernel_without_counting() -> None:
    made, _, transport = server_socket()
    await made.prepare()
    assert transport.high == WRITE_BUFFER


async def test_what_ends_a_connection_is_told_with_its_code() -> None:
    made, response, _ = server_socket()
    response.close_code = 1001
    response.incoming.put_nowait(WSMessage(WSMsgType.CLOSE, 1001, "bye"))
    with pytest.raises(StreamClosed) as raised:
        await made.receive()
    assert (raised.value.code, raised.value.reason) == (1001, "bye")
