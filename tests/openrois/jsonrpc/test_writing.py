"""The way from an outbox to a stream: order, whatever is fast or slow."""

import asyncio
import random

import pytest

from openrois.jsonrpc.outbox import Outbox, OutboxOverflow
from openrois.jsonrpc.unread import UnreadBudget
from openrois.jsonrpc.writing import UNCOUNTED, Writer
from openrois.transport.stream import StreamClosed
from tests.support.session import settle


class Line:
    """A stream that takes batches, and is as slow as the test says."""

    def __init__(self) -> None:
        self.writes: list[list[str]] = []
        self.free = asyncio.Event()
        self.free.set()
        self.closed = False

    @property
    def texts(self) -> list[str]:
        return [text for texts in self.writes for text in texts]

    async def receive(self) -> str:
        raise NotImplementedError

    async def send(self, text: str) -> None:
        await self.send_many([text])

    def send_now(self, text: str) -> bool:
        if self.free.is_set():
            self.writes.append([text])
        return self.free.is_set()

    async def send_many(self, texts: list[str]) -> None:
        if self.closed:
            raise StreamClosed
        written: list[str] = []
        self.writes.append(written)
        for text in texts:
            await self.free.wait()
            written.append(text)

    async def close(self, code: int = 1000, reason: str = "") -> None:
        self.closed = True

    def abort(self) -> None:
        self.closed = True


async def test_one_at_a_time_leaves_at_once_and_many_leave_together() -> None:
    line = Line()
    writer = Writer(line, Outbox())
    running = asyncio.ensure_future(writer.run())
    await settle()
    for text in "ab":
        writer.put(text)
        assert line.texts[-1] == text
        await settle()
    for text in "cdef":
        writer.put(text)
    assert line.texts == ["a", "b", "c"]
    await settle()
    for text in "gh":
        writer.put(text)
    await settle()
    writer.put("i")
    await settle()
    writer.put("j")
    assert line.writes == [["a"], ["b"], ["c"], ["d", "e", "f"], ["g", "h"], ["i"], ["j"]]
    running.cancel()


async def test_while_half_of_a_batch_waits_nothing_passes() -> None:
    line = Line()
    writer = Writer(line, Outbox(control_limit=3, event_limit=1))
    running = asyncio.ensure_future(writer.run())
    writer.put("a")
    writer.put("b")
    line.free.clear()
    await settle()
    for text in "cd":
        writer.put(text)
    for text in "ef":
        writer.put(text, droppable=True)
    line.free.set()
    await settle()
    assert line.texts == ["a", "b", "c", "d", "f"]
    line.free.clear()
    for text in "ghi":
        writer.put(text)
    with pytest.raises(OutboxOverflow):
        writer.put("j")
    line.closed = True
    line.free.set()
    await running


class Slow(Line):
    """A line that takes one message at any time, and sends it when it is free."""

    def send_now(self, text: str) -> bool:
        self.writes.append([text])
        return True


async def test_a_long_message_counts_until_the_stream_has_taken_it() -> None:
    line, outbox, budget = Slow(), Outbox(), UnreadBudget()
    writer = Writer(line, outbox)
    with budget.account("ann", lambda: None) as outbox.account:
        running = asyncio.ensure_future(writer.run())
        await settle()
        line.free.clear()
        long = "a" * (UNCOUNTED + 1)
        writer.put(long)
        await settle()
        assert budget.total == len(long)
        writer.put("b")
        line.free.set()
        await settle()
        assert (line.texts, budget.total) == ([long, "b"], 0)
        writer.put("c" * UNCOUNTED)
        assert line.texts[-1][0] == "c"
        running.cancel()


@pytest.mark.parametrize("seed", range(20))
async def test_order_is_kept(seed: int) -> None:
    chance = random.Random(seed)
    line = Line()
    writer = Writer(line, Outbox())
    running = asyncio.ensure_future(writer.run())
    for number in range(300):
        writer.put(str(number))
        if chance.random() < 0.2:
            line.free.clear()
        for _ in range(chance.choice((0, 0, 1, 2, 5))):
            await asyncio.sleep(0)
        if chance.random() < 0.4:
            line.free.set()
    line.free.set()
    await settle()
    assert line.texts == [str(number) for number in range(300)]
    running.cancel()
