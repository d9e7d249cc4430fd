"""The server's side of a WebSocket at work: several messages in one write, to readers fast and slow."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from websockets.asyncio.client import ClientConnection, connect

from openrois.gateway.socket import ServerSocket
from openrois.transport.stream import StreamClosed
from tests.support.serving import serving
from tests.support.session import settle


@asynccontextmanager
async def joined() -> AsyncIterator[tuple[ServerSocket, ClientConnection]]:
    """A server's end without a reader, and the other end of it."""
    made: asyncio.Future[ServerSocket] = asyncio.get_running_loop().create_future()
    over = asyncio.Event()

    async def serve(socket: ServerSocket) -> None:
        made.set_result(socket)
        await over.wait()

    async with serving(serve) as url, connect(url, max_size=None, max_queue=1, compression=None, proxy=None) as far:
        yield await made, far
        over.set()


TEXTS = ["a", "日本", "b" * 125, "c" * 126, "d" * 65_535, "e" * 65_536, "f" * 200_000, ""]


async def test_messages_of_every_length_arrive_in_order() -> None:
    async with joined() as (near, far), asyncio.timeout(10):
        await near.send_many(TEXTS)
        assert [await far.recv() for _ in TEXTS] == TEXTS


async def test_a_slow_reader_is_waited_for_and_nothing_is_out_of_order() -> None:
    batches = [[f"{number}.{part}" + "x" * 50_000 for part in range(4)] for number in range(100)]
    async with joined() as (near, far), asyncio.timeout(20):

        async def send() -> None:
            for batch in batches:
                await near.send_many(batch)

        sending = asyncio.ensure_future(send())
        # Far more than all buffers on the way hold.
        await settle()
        assert not sending.done()
        for batch in batches:
            assert [await far.recv() for _ in batch] == batch
        await sending


async def test_nothing_is_sent_behind_a_close_frame() -> None:
    async with joined() as (near, far), asyncio.timeout(10):
        await near.close(1001, "over")
        with pytest.raises(StreamClosed) as raised:
            await near.send_many(["a", "b"])
        assert raised.value.code == 1001
        await far.wait_closed()
        assert far.close_code == 1001
