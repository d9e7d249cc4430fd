"""A connection in memory that takes many messages at once."""

import asyncio

import pytest
from openrois_bench.simulation.stream import batch_pair

from openrois.transport.stream import BatchStream, StreamClosed


async def test_messages_arrive_in_order_however_they_were_sent() -> None:
    near, far = batch_pair(8)
    assert isinstance(near, BatchStream)
    assert near.send_now("1")
    await near.send("2")
    await near.send_many(["3", "4"])
    assert [await far.receive() for _ in range(4)] == ["1", "2", "3", "4"]


async def test_a_sender_waits_for_a_slow_reader() -> None:
    near, far = batch_pair(1)
    assert near.send_now("1")
    assert not near.send_now("2")
    sending = asyncio.ensure_future(near.send("2"))
    await asyncio.sleep(0)
    assert not sending.done()
    assert await far.receive() == "1"
    await sending
    assert await far.receive() == "2"


async def test_what_was_sent_before_a_close_is_received() -> None:
    near, far = batch_pair(8)
    await near.send("last")
    await near.close(1001, "done")
    assert await far.receive() == "last"
    for waiting in (far.receive(), far.send("late")):
        with pytest.raises(StreamClosed) as closed:
            await waiting
        assert (closed.value.code, closed.value.reason) == (1001, "done")


async def test_both_sides_that_wait_learn_of_a_lost_connection() -> None:
    near, far = batch_pair(1)
    await near.send("1")
    waiting = [asyncio.ensure_future(near.send("2")), asyncio.ensure_future(near.receive())]
    await asyncio.sleep(0)
    far.abort()
    for each in waiting:
        with pytest.raises(StreamClosed) as closed:
            await each
        assert closed.value.code == 1006
