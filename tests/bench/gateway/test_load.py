"""The applications of the benches: they leave in good order, and do not wait without end for a side that stays."""

import asyncio

import pytest
from openrois_bench.gateway import load
from openrois_bench.gateway.load import Door, applications
from websockets.asyncio.server import ServerConnection, serve


async def test_connections_are_closed_by_the_closing_handshake() -> None:
    codes: asyncio.Queue[int | None] = asyncio.Queue()

    async def serve_one(connection: ServerConnection) -> None:
        await connection.wait_closed()
        codes.put_nowait(connection.close_code)

    async with serve(serve_one, "127.0.0.1", 0) as server:
        port = next(iter(server.sockets)).getsockname()[1]
        async with applications(Door(f"http://127.0.0.1:{port}"), 3) as asked:
            assert all(each.is_open for each in asked)
        assert [await codes.get() for _ in range(3)] == [1000, 1000, 1000]


async def test_a_side_that_does_not_answer_the_close_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(load, "CLOSING", 0.01)
    ended = asyncio.Event()

    async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(b"HTTP/1.1 101 Switching Protocols\r\n\r\n")
        while await reader.read(100):
            pass
        ended.set()
        writer.close()

    server = await asyncio.start_server(answer, "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    async with server:
        async with applications(Door(f"http://127.0.0.1:{port}"), 1) as (application,):
            pass
        assert not application.is_open
        await ended.wait()
