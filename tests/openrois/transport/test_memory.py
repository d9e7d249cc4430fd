"""Two ends in one process; what every stream keeps is in `test_stream_contract`."""

import asyncio

import pytest

from openrois.transport.memory import memory_pair
from openrois.transport.stream import StreamClosed, close_reason


async def test_receive_waits() -> None:
    near, far = memory_pair()
    receiving = asyncio.ensure_future(far.receive())
    await asyncio.sleep(0)
    assert not receiving.done()
    await near.send("a")
    assert await receiving == "a"


async def test_send_waits_while_the_other_end_does_not_take() -> None:
    near, far = memory_pair(capacity=1)
    await near.send("a")
    sending = asyncio.ensure_future(near.send("b"))
    for _ in range(3):
        await asyncio.sleep(0)
    assert not sending.done()
    assert await far.receive() == "a"
    await sending
    assert await far.receive() == "b"


async def test_a_waiting_reader_learns_the_end() -> None:
    near, far = memory_pair(capacity=1)
    await near.send("a")
    sending, receiving = asyncio.ensure_future(near.send("b")), asyncio.ensure_future(near.receive())
    await asyncio.sleep(0)
    far.abort()
    await far.close(1000)
    for waiting in (sending, receiving):
        with pytest.raises(StreamClosed) as raised:
            await waiting
        assert raised.value.code == 1006


def test_a_close_reads_as_what_it_is() -> None:
    assert str(StreamClosed(1008, "no")) == "closed with 1008 no"
    assert str(StreamClosed()) == "closed with 1000"


@pytest.mark.parametrize(
    ("text", "cut"),
    [("short", "short"), ("x" * 200, "x" * 123), ("日" * 100, "日" * 41), ("a\ud800b", "a?b"), ("", "")],
)
def test_a_reason_fits_into_its_frame_in_whole_characters(text: str, cut: str) -> None:
    assert close_reason(text) == cut
