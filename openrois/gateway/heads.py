"""Connections that have not said what they want: each has so long for that, and of too many the oldest is cut."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Final

from aiohttp import web
from aiohttp.typedefs import Middleware

__all__ = ["HEAD_TIMEOUT", "Heads"]

HEAD_TIMEOUT: Final = 10.0
"""Seconds from the connection, or the last answer on it, to the end of a request's head.

The server library has no such limit."""

MAX_HEADS: Final = 512
"""Connections whose head is waited for; one more cuts the oldest, and those who mean it need a moment only."""

_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


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
        self._waiting: dict[web.RequestHandler, asyncio.TimerHandle] = {}

    def __call__(self) -> web.RequestHandler:
        """Return the protocol of a connection that comes in."""
        protocol = self.protocols()
        self._expect(protocol)
        return protocol

    def count(self) -> int:
        """Return how many there are."""
        return len(self._waiting)

    def middleware(self) -> Middleware:
        """Return what has to see every request: its head has come, and from its answer on the next is waited for."""

        @web.middleware
        async def timely(request: web.Request, handler: _Handler) -> web.StreamResponse:
            if (waiting := self._waiting.pop(request.protocol, None)) is not None:
                waiting.cancel()
            try:
                return await handler(request)
            finally:
                if request.transport is not None:
                    self._expect(request.protocol)

        return timely

    def _expect(self, protocol: web.RequestHandler) -> None:
        if len(self._waiting) >= MAX_HEADS:
            self._cut(next(iter(self._waiting)))
        self._waiting[protocol] = asyncio.get_running_loop().call_later(HEAD_TIMEOUT, self._cut, protocol)

    def _cut(self, protocol: web.RequestHandler) -> None:
        self._waiting.pop(protocol).cancel()
        # Some have gone by themselves.
        if protocol.transport is not None:
            self._turned_away("no request")
            protocol.transport.abort()
