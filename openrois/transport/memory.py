"""Two ends of a message stream in one process, with the same bounds as a socket and no socket."""

import asyncio
from collections import deque

from openrois.transport.stream import StreamClosed

__all__ = ["MemoryStream", "memory_pair"]


class _Pipe:
    """One direction: what was sent and not received yet."""

    def __init__(self, capacity: int) -> None:
        self.capacity = capacity
        self.messages: deque[str] = deque()
        self.readable = asyncio.Event()
        self.writable = asyncio.Event()


class MemoryStream:
    """One end of a pair made by `memory_pair`; a `MessageStream`."""

    def __init__(self, incoming: _Pipe, outgoing: _Pipe) -> None:
        self._incoming = incoming
        self._outgoing = outgoing
        self._closed: StreamClosed | None = None
        self._other = self

    async def receive(self) -> str:
        """Return the next message; what was sent before a close is still received."""
        pipe = self._incoming
        while not pipe.messages:
            if self._closed is not None:
                raise self._closed
            pipe.readable.clear()
            await pipe.readable.wait()
        pipe.writable.set()
        return pipe.messages.popleft()

    async def send(self, text: str) -> None:
        """Hand over one message; waits while the other end has not taken what came before."""
        pipe = self._outgoing
        while self._closed is None and len(pipe.messages) >= pipe.capacity:
            pipe.writable.clear()
            await pipe.writable.wait()
        if self._closed is not None:
            raise self._closed
        pipe.messages.append(text)
        pipe.readable.set()

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """End both ends; the other end may still receive what is on its way."""
        self._end_stream(StreamClosed(code, reason))

    def abort(self) -> None:
        """End both ends as a broken connection would."""
        self._end_stream(StreamClosed(1006))

    def _end_stream(self, closed: StreamClosed) -> None:
        for end in (self, self._other):
            end._closed = end._closed or closed
            end._incoming.readable.set()
            end._outgoing.writable.set()


def memory_pair(capacity: int = 64) -> tuple[MemoryStream, MemoryStream]:
    """Return two connected ends; each direction holds `capacity` messages before `send` waits."""
    one_way, other_way = _Pipe(capacity), _Pipe(capacity)
    near, far = MemoryStream(one_way, other_way), MemoryStream(other_way, one_way)
    near._other, far._other = far, near
    return near, far
