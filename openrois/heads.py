"""Connections that have not said what they want: each has so long for that, and of too many the oldest is cut."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Final

from aiohttp import web
from aiohttp.typedefs import Middleware

from openrois.http_log import HTTP_LOG

__all__ = ["HEAD_TIMEOUT", "OPTIONS", "Heads"]

HEAD_TIMEOUT: Final = 10.0
"""Seconds from the connection, or the last answer on it, to the end of a request's head.

The server library has no such limit."""

MAX_HEADS: Final = 512
"""Connections whose head is waited for; one more cuts the oldest, and those who mean it need a moment only."""

MAX_HEAD: Final = 64 * 1024
"""Bytes that may come while a head is waited for; one more cuts the connection.

The server library bounds each line and their number, and keeps all that comes after what it could not read."""

OPTIONS: Final[dict[str, Any]] = {"logger": HTTP_LOG, "access_log": None, "keepalive_timeout": 0.8 * HEAD_TIMEOUT}
"""What the server library is told of connections: one that was answered and says nothing is closed, in good order,
before it is cut."""

_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


@dataclass(slots=True)
class _Waiting:
    """A head that is waited for: until the timer rings, and for so many bytes."""

    timer: asyncio.TimerHandle
    room: int = MAX_HEAD


class Heads:
    """The connections of one port whose next request has not come.

    Args:
        turned_away: told the reason whenever one is cut.

    Attributes:
        protocols: makes the protocol of a new connection; to be set before there is one.
    """

    protocols: Callable[[], web.RequestHandler]

    def __init__(self, turned_away: Callable[[str], None]) -> None:
        self._turned_away = turned_away
        self._waiting: dict[web.RequestHandler, _Waiting] = {}

    def __call__(self) -> asyncio.Protocol:
        """Return the protocol of a connection that comes in."""
        protocol = self.protocols()
        self._expect(protocol)
        return _Doorstep(protocol, self)

    def count(self) -> int:
        """Return how many there are."""
        return len(self._waiting)

    def middleware(self) -> Middleware:
        """Return what has to see every request: its head has come, and from its answer on the next is waited for."""

        @web.middleware
        async def timely(request: web.Request, handler: _Handler) -> web.StreamResponse:
            self.forget(request.protocol)
            try:
                return await handler(request)
            finally:
                if request.transport is not None:
                    self._expect(request.protocol)

        return timely

    def _expect(self, protocol: web.RequestHandler) -> None:
        if len(self._waiting) >= MAX_HEADS:
            self._cut(next(iter(self._waiting)))
        self._waiting[protocol] = _Waiting(asyncio.get_running_loop().call_later(HEAD_TIMEOUT, self._cut, protocol))

    def takes(self, protocol: web.RequestHandler, count: int) -> bool:
        """Tell whether a connection may say so many bytes more; one that may not is cut."""
        waiting = self._waiting.get(protocol)
        if waiting is None:
            return True
        waiting.room -= count
        if waiting.room < 0:
            self._cut(protocol)
        return waiting.room >= 0

    def forget(self, protocol: web.RequestHandler) -> None:
        """Wait for nothing more of a connection: a head has come, or it is gone."""
        if (waiting := self._waiting.pop(protocol, None)) is not None:
            waiting.timer.cancel()

    def _cut(self, protocol: web.RequestHandler) -> None:
        self.forget(protocol)
        # Some are not there yet, or not any more.
        if protocol.transport is not None:
            self._turned_away("no request")
            protocol.transport.abort()


class _Doorstep(asyncio.Protocol):
    """Stands before the server library's protocol of one connection, and passes on what that may hear."""

    def __init__(self, protocol: web.RequestHandler, heads: Heads) -> None:
        self._protocol = protocol
        self._heads = heads
        # The transport asks for these.
        self.pause_writing = protocol.pause_writing  # type: ignore[method-assign]
        self.resume_writing = protocol.resume_writing  # type: ignore[method-assign]

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._protocol.connection_made(transport)

    def data_received(self, data: bytes) -> None:
        if self._heads.takes(self._protocol, len(data)):
            self._protocol.data_received(data)

    def eof_received(self) -> None:
        self._protocol.eof_received()

    def connection_lost(self, exc: Exception | None) -> None:
        self._heads.forget(self._protocol)
        self._protocol.connection_lost(exc)
