"""The dialling side, against a plain WebSocket server."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress

import pytest
from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import InvalidHandshake, InvalidURI

from openrois.aio.tasks import TaskScope
from openrois.transport import websocket
from openrois.transport.stream import StreamClosed
from openrois.transport.websocket import MAX_MESSAGE, WebSocketStream, dial
from tests.support.ways import by_relay


@asynccontextmanager
async def serving(handle: Callable[[ServerConnection], Awaitable[None]]) -> AsyncIterator[str]:
    async with serve(handle, "127.0.0.1", 0, close_timeout=1) as server:
        yield f"ws://127.0.0.1:{server.sockets[0].getsockname()[1]}/"


@asynccontextmanager
async def deaf() -> AsyncIterator[str]:
    """A server that reads nothing, and is gone when the block ends."""
    left = asyncio.Event()

    async def read_nothing(far: ServerConnection) -> None:
        far.transport.pause_reading()
        await left.wait()
        far.transport.abort()

    async with serving(read_nothing) as url:
        try:
            yield url
        finally:
            left.set()


async def echo(far: ServerConnection) -> None:
    async for message in far:
        await far.send(message)


async def test_messages_there_and_back() -> None:
    async with serving(echo) as url, dial(url) as near:
        for text in ("a", "日本", "x" * 1_000_000):
            await near.send(text)
            assert await near.receive() == text


async def test_the_other_side_closes() -> None:
    async def refuse(far: ServerConnection) -> None:
        await far.close(1008, "no")

    async with serving(refuse) as url, dial(url) as near:
        with pytest.raises(StreamClosed) as raised:
            await near.receive()
        assert (raised.value.code, raised.value.reason) == (1008, "no")
        with pytest.raises(StreamClosed):
            await near.send("x")


async def test_the_other_side_breaks_off() -> None:
    async def break_off(far: ServerConnection) -> None:
        far.transport.abort()

    async with serving(break_off) as url, dial(url) as near:
        with pytest.raises(StreamClosed) as raised:
            await near.receive()
        assert raised.value.code == 1006


async def test_a_side_that_says_nothing_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websocket, "_PING_INTERVAL", 0.01)
    monkeypatch.setattr(websocket, "_PING_TIMEOUT", 0.01)

    async with deaf() as url, asyncio.timeout(60), dial(url) as near:
        with pytest.raises(StreamClosed) as raised:
            await near.receive()
        assert (raised.value.code, raised.value.reason) == (1011, "no answer to a ping")


async def test_a_side_whose_answers_wait_unread_behind_what_it_said_is_not_blamed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(websocket, "_PING_INTERVAL", 0.01)
    monkeypatch.setattr(websocket, "_PING_TIMEOUT", 0.01)

    async def say_much(far: ServerConnection) -> None:
        for number in range(100):
            await far.send(str(number))
        await far.wait_closed()

    async with serving(say_much) as url, asyncio.timeout(60), dial(url) as near:
        await passing(0.2)
        monkeypatch.undo()
        # The ping that is under way has its end before anything is read.
        await passing(0.02)
        assert [await near.receive() for _ in range(100)] == [str(number) for number in range(100)]
        await near.send("x")


async def test_a_side_that_takes_nothing_in_is_left_and_can_be_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websocket, "_PING_INTERVAL", 0.01)
    monkeypatch.setattr(websocket, "_PING_TIMEOUT", 0.01)
    async with deaf() as url:
        async with asyncio.timeout(60):
            async with dial(url) as near, TaskScope() as tasks:
                full = tasks.start(_fill(near))
                with pytest.raises(StreamClosed):
                    await near.receive()
                await full
            monkeypatch.undo()
            async with dial(url) as near, TaskScope() as tasks:
                full = tasks.start(_fill(near))
                while not near._connection.transport.get_write_buffer_size():
                    await passing(0.01)


async def _fill(near: WebSocketStream) -> None:
    with suppress(StreamClosed):
        while True:
            await near.send("x" * 1_000_000)


async def passing(seconds: float) -> None:
    """Let time pass: nothing else shows that nothing happens in it."""
    over = asyncio.get_running_loop().create_future()
    asyncio.get_running_loop().call_later(seconds, over.set_result, None)
    await over


async def test_we_close_with_a_reason_that_fits() -> None:
    closed: asyncio.Future[tuple[int | None, str | None]] = asyncio.get_running_loop().create_future()

    async def wait(far: ServerConnection) -> None:
        await far.wait_closed()
        closed.set_result((far.close_code, far.close_reason))

    async with serving(wait) as url, dial(url) as near:
        await near.close(1001, "日" * 100)
        assert await closed == (1001, "日" * 41)


async def test_we_break_off() -> None:
    closed: asyncio.Future[int | None] = asyncio.get_running_loop().create_future()

    async def wait(far: ServerConnection) -> None:
        await far.wait_closed()
        closed.set_result(far.close_code)

    async with serving(wait) as url, dial(url) as near:
        near.abort()
        assert await closed == 1006
        with pytest.raises(StreamClosed):
            await near.receive()


async def test_binary_messages_are_refused() -> None:
    async def binary(far: ServerConnection) -> None:
        await far.send(b"x")
        await far.wait_closed()

    async with serving(binary) as url, dial(url) as near:
        with pytest.raises(StreamClosed) as raised:
            await near.receive()
        assert raised.value.code == 1003


async def test_what_cannot_be_dialled() -> None:
    async with serving(echo) as url:
        free = url
    with pytest.raises(OSError):
        async with dial(free):
            raise AssertionError("nothing listens here")
    with pytest.raises(InvalidURI):
        async with dial("http://127.0.0.1:1/"):
            raise AssertionError("no WebSocket address")

    async def not_http(_reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n")
        writer.close()

    async with await asyncio.start_server(not_http, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        with pytest.raises(InvalidHandshake):
            async with dial(f"ws://127.0.0.1:{port}/"):
                raise AssertionError("no WebSocket server")


@pytest.mark.parametrize("size", [MAX_MESSAGE, MAX_MESSAGE + 1])
async def test_a_message_may_be_so_long(size: int) -> None:
    async def say(far: ServerConnection) -> None:
        await far.send("x" * size)
        await far.wait_closed()

    async with serving(say) as url, dial(url) as near:
        if size == MAX_MESSAGE:
            assert len(await near.receive()) == size
        else:
            with pytest.raises(StreamClosed) as raised:
                await near.receive()
            assert raised.value.code == 1009


async def test_many_at_once_arrive_in_order_and_none_after_the_end() -> None:
    texts = ["a", "日本", *("x" * length for length in (125, 126, 65_535, 65_536, 500_000)), ""]
    async with serving(echo) as url, dial(url) as near:
        for batch in (texts, ["alone"], texts):
            await near.send_many(batch)
        assert [await near.receive() for _ in range(2 * len(texts) + 1)] == [*texts, "alone", *texts]
        await near.close()
        with pytest.raises(StreamClosed):
            await near.send_many(["a", "b"])


@pytest.mark.parametrize(("doubt_after", "arrives"), [(None, True), (0.0, False)])
async def test_what_has_waited_on_the_way_is_not_taken_from_a_side_that_has_left(
    doubt_after: float | None, arrives: bool
) -> None:
    may_leave = asyncio.Event()

    async def leave(far: ServerConnection) -> None:
        await far.send("hello")
        await may_leave.wait()
        await far.send("old")
        far.transport.close()

    async with (
        serving(leave) as url,
        by_relay(url.split("/")[2]) as way,
        dial(f"ws://{way.address}/", doubt_after=doubt_after) as near,
    ):
        assert await near.receive() == "hello"
        way.block()
        may_leave.set()
        receiving = asyncio.ensure_future(near.receive())
        way.open()
        if arrives:
            assert await receiving == "old"
        else:
            with pytest.raises(StreamClosed):
                await receiving


async def test_what_comes_after_a_silence_is_taken_in_order_when_the_other_side_answers() -> None:
    async def burst(far: ServerConnection) -> None:
        for number in range(200):
            await far.send(str(number))
        await far.wait_closed()

    async with serving(burst) as url, dial(url, doubt_after=0.0) as near:
        assert [await near.receive() for _ in range(200)] == [str(number) for number in range(200)]


async def test_more_than_is_held_back_after_a_silence_ends_the_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websocket, "_MOST_HELD", 10)

    async def mute(far: ServerConnection) -> None:
        assert await far.recv() == "hello"
        # Nothing more is read, and so no ping is answered.
        far.transport.pause_reading()
        await far.send("x" * 11)
        await far.wait_closed()

    async with serving(mute) as url, dial(url, doubt_after=0.0) as near:
        await near.send("hello")
        with pytest.raises(StreamClosed):
            await near.receive()
