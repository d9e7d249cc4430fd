"""What every message stream keeps: in memory, over a WebSocket of client and gateway, over NATS between gateways."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from typing import TYPE_CHECKING

import pytest

from openrois.gateway.socket import APPLICATION, ServerSocket, SocketProfile
from openrois.transport.memory import memory_pair
from openrois.transport.stream import BatchStream, MessageStream, StreamClosed
from openrois.transport.websocket import dial
from tests.support.serving import serving

if TYPE_CHECKING:
    from tests.support.nats import NatsServer

Ends = tuple[MessageStream, MessageStream]
Connect = Callable[[], AbstractAsyncContextManager[Ends]]

LONG = 1_000_000
LARGE = SocketProfile(2 * LONG, APPLICATION.ping_interval, APPLICATION.ping_timeout)


@asynccontextmanager
async def in_memory() -> AsyncIterator[Ends]:
    yield memory_pair()


@asynccontextmanager
async def over_websocket() -> AsyncIterator[Ends]:
    accepted: asyncio.Queue[ServerSocket] = asyncio.Queue()
    over = asyncio.Event()

    async def hold(end: ServerSocket) -> None:
        await accepted.put(end)
        await over.wait()

    async with serving(hold, LARGE) as url, dial(url) as near:
        try:
            yield near, await accepted.get()
        finally:
            over.set()


@pytest.fixture(params=["memory", "websocket", "nats"])
def connect(request: pytest.FixtureRequest) -> Connect:
    if request.param != "nats":
        return {"memory": in_memory, "websocket": over_websocket}[request.param]
    server: NatsServer = request.getfixturevalue("shared_nats")
    from tests.support.nats import dialled, links

    @asynccontextmanager
    async def over_nats() -> AsyncIterator[Ends]:
        async with links(server.url, server.url) as (near, far), dialled(near, far) as pair:
            yield await pair()

    return over_nats


async def test_messages_arrive_in_order_both_ways(connect: Connect) -> None:
    texts = ["a", "日本", "", "\0", *("x" * length for length in (125, 126, 65_535, 65_536, LONG)), "z"]
    async with connect() as ends:
        for sender, receiver in (ends, ends[::-1]):
            sending = asyncio.ensure_future(send_all(sender, texts))
            assert [await receiver.receive() for _ in texts] == texts
            await sending


async def send_all(stream: MessageStream, texts: list[str]) -> None:
    for text in texts:
        await stream.send(text)


async def test_both_directions_are_used_at_the_same_time(connect: Connect) -> None:
    texts = [str(number) * 50 for number in range(500)]

    async def receive_all(stream: MessageStream) -> list[str]:
        return [await stream.receive() for _ in texts]

    async with connect() as (near, far):
        received = await asyncio.gather(
            receive_all(near), receive_all(far), send_all(near, texts), send_all(far, texts)
        )
    assert received[:2] == [texts, texts]


async def test_a_sender_waits_for_a_receiver_that_does_not_read(connect: Connect) -> None:
    text = "x" * 100_000
    sent = 0

    async def send_much() -> None:
        nonlocal sent
        while sent < 1000:
            await near.send(text)
            sent += 1

    async with connect() as (near, far):
        sending = asyncio.ensure_future(send_much())
        before = -1
        while sent != before:
            before = sent
            await asyncio.wait({sending}, timeout=0.2)
        assert not sending.done()
        for _ in range(100):
            assert await far.receive() == text
        sending.cancel()
        await asyncio.wait({sending})


@pytest.mark.parametrize("closing", [0, 1])
async def test_what_was_sent_before_a_close_is_received_and_then_the_reason(connect: Connect, closing: int) -> None:
    async with connect() as ends:
        closer, other = ends[closing], ends[1 - closing]
        for text in ("a", "b"):
            await closer.send(text)
        ending = asyncio.ensure_future(closer.close(4001, "日" * 40))
        assert [await other.receive(), await other.receive()] == ["a", "b"]
        with pytest.raises(StreamClosed) as raised:
            await other.receive()
        assert (raised.value.code, raised.value.reason) == (4001, "日" * 40)
        await ending
        for end in ends:
            await end.close(1000, "again")
            with pytest.raises(StreamClosed):
                await end.send("x")
            with pytest.raises(StreamClosed):
                await end.receive()


@pytest.mark.parametrize("aborting", [0, 1])
async def test_all_that_waits_learns_that_the_other_side_broke_off(connect: Connect, aborting: int) -> None:
    async with connect() as ends:
        waiting = [asyncio.ensure_future(end.receive()) for end in ends]
        await asyncio.wait(waiting, timeout=0.05)
        ends[aborting].abort()
        ends[aborting].abort()
        for each in waiting:
            with pytest.raises(StreamClosed) as raised:
                await each
            assert raised.value.code == 1006


async def test_a_sender_that_waits_learns_the_end(connect: Connect) -> None:
    async with connect() as (near, far):
        sending = asyncio.ensure_future(send_all(near, ["x" * 500_000] * 1000))
        await asyncio.wait({sending}, timeout=0.5)
        far.abort()
        with pytest.raises(StreamClosed):
            await sending


async def test_many_messages_at_once_stand_in_one_order_with_single_ones(connect: Connect) -> None:
    texts = ["a", "日本", *("x" * length for length in (125, 126, 65_535, 65_536, 500_000)), ""]
    async with connect() as ends:
        for sender, receiver in (ends, ends[::-1]):
            if not isinstance(sender, BatchStream):
                continue
            sending = asyncio.ensure_future(send_mixed(sender, texts))
            expected = ["now", *texts, "alone", *texts]
            assert [await receiver.receive() for _ in expected] == expected
            await sending


async def send_mixed(sender: BatchStream, texts: list[str]) -> None:
    assert sender.send_now("now")
    for batch in (texts, ["alone"], texts):
        await sender.send_many(batch)


async def test_nothing_is_sent_at_once_or_together_after_the_end(connect: Connect) -> None:
    async with connect() as ends:
        for end in ends:
            if isinstance(end, BatchStream):
                await end.close()
                assert not end.send_now("x")
                with pytest.raises(StreamClosed):
                    await end.send_many(["a", "b"])
