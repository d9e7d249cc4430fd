"""Connections that have not said what they want: each has so long for that, and of too many the oldest is cut."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Final

from aiohttp import web
from aiohttp.typedefs import Middleware

from openrois.http_log import HTTP_LOG

__all__ = ["HEAD_TIMEOUT", "OPTIONS", "Connection", "Heads"]

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
    """

    def __init__(self, turned_away: Callable[[str], None]) -> None:
        self._turned_away = turned_away
        self._waiting: dict[web.RequestHandler, _Waiting] = {}

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
                    self.expect(request.protocol)

        return timely

    def expect(self, protocol: web.RequestHandler) -> None:
        """Wait for the next head of a connection; of too many the oldest is cut."""
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


class Connection(web.RequestHandler):
    """A connection of the server library whose heads are bounded.

    Args:
        manager: the library's server.
        heads: those of the port.
        options: of `web.RequestHandler`.
    """

    __slots__ = ("_heads",)

    def __init__(self, manager: web.Server, heads: Heads, **options: Any) -> None:
        super().__init__(manager, **options)
        self._heads = heads
        heads.expect(self)

    def data_received(self, data: bytes) -> None:
        """Take what has come, if so much may."""
        if self._heads.takes(self, len(data)):
            super().data_received(data)

    def connection_lost(self, exc: BaseException | None) -> None:
        """End; nothing more is waited for."""
        self._heads.forget(self)
        super().connection_lost(exc)
