"""A connection in memory that takes many messages at once, as a socket does."""

import asyncio
from collections.abc import Sequence

from openrois.transport.stream import StreamClosed

__all__ = ["BatchEnd", "batch_pair"]


class _Direction:
    """What was sent one way and not received yet; each future is there while one side waits."""

    __slots__ = ("messages", "readable", "writable")

    def __init__(self) -> None:
        # A deque takes a page even while it is empty, which nearly all are.
        self.messages: list[str] = []
        self.readable: asyncio.Future[None] | None = None
        self.writable: asyncio.Future[None] | None = None


class BatchEnd:
    """One end of a pair made by `batch_pair`; a `BatchStream`.

    `openrois.transport.memory` takes one message at a time, so that a session over it has a task woken for each. Over a
    socket what a session has to send leaves at once, or all of a turn of the loop together: that is what is simulated.
    There are hundreds of thousands of these: futures are made only while one side waits.
    """

    __slots__ = ("_capacity", "_closed", "_incoming", "_other", "_outgoing")

    def __init__(self, incoming: _Direction, outgoing: _Direction, capacity: int) -> None:
        self._incoming = incoming
        self._outgoing = outgoing
        self._capacity = capacity
        self._closed: StreamClosed | None = None
        self._other = self

    async def receive(self) -> str:
        """Return the next message; what was sent before a close is still received."""
        way = self._incoming
        while not way.messages:
            if self._closed is not None:
                raise self._closed
            way.readable = asyncio.get_running_loop().create_future()
            await way.readable
        text = way.messages.pop(0)
        _wake(way.writable)
        return text

    async def send(self, text: str) -> None:
        """Hand over one message; waits while the other end has not taken what came before."""
        while not self.send_now(text):
            if self._closed is not None:
                raise self._closed
            self._outgoing.writable = asyncio.get_running_loop().create_future()
            await self._outgoing.writable

    def send_now(self, text: str) -> bool:
        """Hand over one message if there is room for it, and tell whether there was."""
        way = self._outgoing
        if self._closed is not None or len(way.messages) >= self._capacity:
            return False
        way.messages.append(text)
        _wake(way.readable)
        return True

    async def send_many(self, texts: Sequence[str]) -> None:
        """Hand over messages in this order; waits while the other end is slow."""
        for text in texts:
            await self.send(text)

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """End both ends; the other end may still receive what is on its way."""
        self._end(StreamClosed(code, reason))

    def abort(self) -> None:
        """End both ends as a broken connection would."""
        self._end(StreamClosed(1006))

    def _end(self, closed: StreamClosed) -> None:
        for end in (self, self._other):
            end._closed = end._closed or closed
            _wake(end._incoming.readable)
            _wake(end._outgoing.writable)


def _wake(waiting: asyncio.Future[None] | None) -> None:
    if waiting is not None and not waiting.done():
        waiting.set_result(None)


def batch_pair(capacity: int) -> tuple[BatchEnd, BatchEnd]:
    """Return two connected ends; each direction holds `capacity` messages before `send` waits."""
    one_way, other_way = _Direction(), _Direction()
    near, far = BatchEnd(one_way, other_way, capacity), BatchEnd(other_way, one_way, capacity)
    near._other, far._other = far, near
    return near, far
