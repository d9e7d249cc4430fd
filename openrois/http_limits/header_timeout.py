"""Limits how long a client may take to send its request header, and how many connections wait for theirs."""

import asyncio
import resource
import socket
from collections import Counter
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Final, cast

from aiohttp import web
from aiohttp.typedefs import Middleware

from openrois.observability.http_log import HTTP_LOG

__all__ = ["HEAD_TIMEOUT", "MAX_SILENT", "MAX_SILENT_PER_ADDRESS", "OPTIONS", "Connection", "HeaderTimeouts"]

HEAD_TIMEOUT: Final = 10.0
"""Seconds from the accepted connection, or the last answer on it, to the end of a request's head; the TLS handshake
included. The server library has no such limit."""

MAX_SILENT: Final = 512
"""Connections of a port whose head is waited for; one more cuts the oldest: a genuine client needs a moment only."""

MAX_SILENT_PER_ADDRESS: Final = 256
"""Those of them from one address; one more cuts the oldest of that address."""

LEAST_TIME: Final = 0.25
"""Seconds that a silent connection has before it is cut for being one too many; until then the next is not accepted."""

PER_DESCRIPTOR: Final = 0.25
"""Of the file descriptors of the process, so many may be silent connections."""

MAX_HEAD: Final = 64 * 1024
"""Bytes that may come while a head is waited for; one more cuts the connection.

The server library bounds each line and their number, and keeps all that comes after what it could not read."""

OPTIONS: Final[dict[str, Any]] = {"logger": HTTP_LOG, "access_log": None, "keepalive_timeout": 0.8 * HEAD_TIMEOUT}
"""Keep-alive time for the server library: an answered, idle connection is closed, in good order,
before it is cut."""

_Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


@dataclass(slots=True)
class _Waiting:
    """A head that is waited for: since when, until the timer rings, and for so many bytes."""

    since: float
    timer: asyncio.TimerHandle
    room: int = MAX_HEAD


class HeaderTimeouts:
    """The connections of one port, and those of them whose next request has not come.

    Args:
        turned_away: called with the reason whenever one is cut.
        most: how many may be silent at a time; where the process may open few files, less.
        per_address: how many of them from one address.
    """

    def __init__(
        self,
        turned_away: Callable[[str], None],
        most: int = MAX_SILENT,
        per_address: int = MAX_SILENT_PER_ADDRESS,
    ) -> None:
        self._turned_away = turned_away
        descriptors, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
        few = descriptors != resource.RLIM_INFINITY
        self._most = max(1, min(most, int(PER_DESCRIPTOR * descriptors))) if few else most
        self._per_address = per_address
        self._open: set[Connection] = set()
        self._waiting: dict[Connection, _Waiting] = {}
        self._of_address: Counter[str] = Counter()
        self._gone = asyncio.Event()

    @property
    def silent(self) -> int:
        """Number of connections that wait for a request header."""
        return len(self._waiting)

    @property
    def open(self) -> int:
        """Number of connections, from accept on."""
        return len(self._open)

    def middleware(self) -> Middleware:
        """Return the middleware of all requests: the header has come, and behind the answer the next is waited for."""

        @web.middleware
        async def timely(request: web.Request, handler: _Handler) -> web.StreamResponse:
            connection = cast(Connection, request.protocol)
            self.forget_connection(connection)
            try:
                return await handler(request)
            finally:
                if request.transport is not None:
                    self.expect(connection)

        return timely

    def join(self, connection: "Connection") -> None:
        """Count a connection that was accepted, and wait for its first header."""
        self._open.add(connection)
        self.expect(connection)

    def leave(self, connection: "Connection") -> None:
        """Remove a connection that has ended."""
        self._open.discard(connection)
        self.forget_connection(connection)

    def expect(self, connection: "Connection") -> None:
        """Wait for the next header of a connection; of too many the oldest is cut."""
        if (oldest := self._one_too_many(connection.address)) is not None:
            self._cut(oldest)
        self._of_address[connection.address] += 1
        loop = asyncio.get_running_loop()
        timer = loop.call_later(HEAD_TIMEOUT, self._cut, connection)
        self._waiting[connection] = _Waiting(loop.time(), timer)

    async def wait_for_room(self, address: str) -> None:
        """Wait until a connection from this address may cut the one that it takes the place of, if any."""
        clock = asyncio.get_running_loop().time
        while (oldest := self._one_too_many(address)) is not None:
            if (seconds := self._waiting[oldest].since + LEAST_TIME - clock()) <= 0:
                return
            self._gone.clear()
            with suppress(TimeoutError):
                async with asyncio.timeout(seconds):
                    await self._gone.wait()

    def _one_too_many(self, address: str) -> "Connection | None":
        """Return which connection has to be cut for one more from this address."""
        if self._of_address[address] >= self._per_address:
            return next(each for each in self._waiting if each.address == address)
        return next(iter(self._waiting)) if len(self._waiting) >= self._most else None

    def cut_oldest(self) -> None:
        """Cut the connection that has been silent for longest, where there is one."""
        if self._waiting:
            self._cut(next(iter(self._waiting)))

    def takes(self, connection: "Connection", count: int) -> bool:
        """Count bytes of a connection; tell whether they fit, and cut it where they do not."""
        waiting = self._waiting.get(connection)
        if waiting is None:
            return True
        waiting.room -= count
        if waiting.room < 0:
            self._cut(connection)
        return waiting.room >= 0

    def forget_connection(self, connection: "Connection") -> None:
        """Wait for nothing more of a connection: its header has come, or it is gone."""
        if (waiting := self._waiting.pop(connection, None)) is None:
            return
        waiting.timer.cancel()
        self._gone.set()
        self._of_address[connection.address] -= 1
        if not self._of_address[connection.address]:
            del self._of_address[connection.address]

    def _cut(self, connection: "Connection") -> None:
        self.forget_connection(connection)
        if connection.abort():
            self._turned_away("no request")


class Connection(web.RequestHandler):
    """A connection of the server library whose headers are bounded.

    Args:
        manager: the library's server.
        header_timeouts: those of the port.
        address: the remote one.
        options: of `web.RequestHandler`.

    Attributes:
        address: the remote one.
        unopened: its socket, until it is open: with TLS that takes a handshake.
    """

    __slots__ = ("_header_timeouts", "address", "unopened")

    def __init__(self, manager: web.Server, header_timeouts: HeaderTimeouts, address: str, **options: Any) -> None:
        super().__init__(manager, **options)
        self._header_timeouts = header_timeouts
        self.address = address
        self.unopened: socket.socket | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin: the transport has the socket from here on."""
        self.unopened = None
        super().connection_made(transport)

    def data_received(self, data: bytes) -> None:
        """Receive bytes, within the limit."""
        if self._header_timeouts.takes(self, len(data)):
            super().data_received(data)

    def connection_lost(self, exc: BaseException | None) -> None:
        """End; nothing more is waited for."""
        self._header_timeouts.leave(self)
        super().connection_lost(exc)

    def abort(self) -> bool:
        """End at once, and tell whether there was something to end."""
        if self.unopened is not None:
            # Its transport, if it has one by now, sees the end and closes it.
            with suppress(OSError):
                self.unopened.shutdown(socket.SHUT_RDWR)
            return True
        if self.transport is None:
            return False
        self.transport.abort()
        return True
