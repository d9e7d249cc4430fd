"""Connections that have not said what they want: each has so long for that, and of too many the oldest is cut."""

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
"""What the server library is told of connections: one that was answered and says nothing is closed, in good order,
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
        turned_away: told the reason whenever one is cut.
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
        """How many connections wait to be told what they are for."""
        return len(self._waiting)

    @property
    def open(self) -> int:
        """How many connections there are, from their being accepted on."""
        return len(self._open)

    def middleware(self) -> Middleware:
        """Return what has to see every request: its head has come, and from its answer on the next is waited for."""

        @web.middleware
        async def timely(request: web.Request, handler: _Handler) -> web.StreamResponse:
            connection = cast(Connection, request.protocol)
            self.forget(connection)
            try:
                return await handler(request)
            finally:
                if request.transport is not None:
                    self.expect(connection)

        return timely

    def join(self, connection: "Connection") -> None:
        """Count a connection that has been accepted, and wait for its first head."""
        self._open.add(connection)
        self.expect(connection)

    def leave(self, connection: "Connection") -> None:
        """Count a connection no more: it has ended."""
        self._open.discard(connection)
        self.forget(connection)

    def expect(self, connection: "Connection") -> None:
        """Wait for the next head of a connection; of too many the oldest is cut."""
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
        """Tell whether a connection may say so many bytes more; one that may not is cut."""
        waiting = self._waiting.get(connection)
        if waiting is None:
            return True
        waiting.room -= count
        if waiting.room < 0:
            self._cut(connection)
        return waiting.room >= 0

    def forget(self, connection: "Connection") -> None:
        """Wait for nothing more of a connection: a head has come, or it is gone."""
        if (waiting := self._waiting.pop(connection, None)) is None:
            return
        waiting.timer.cancel()
        self._gone.set()
        self._of_address[connection.address] -= 1
        if not self._of_address[connection.address]:
            del self._of_address[connection.address]

    def _cut(self, connection: "Connection") -> None:
        self.forget(connection)
        if connection.abort():
            self._turned_away("no request")


class Connection(web.RequestHandler):
    """A connection of the server library whose heads are bounded.

    Args:
        manager: the library's server.
        heads: those of the port.
        address: the remote one.
        options: of `web.RequestHandler`.

    Attributes:
        address: the remote one.
        unopened: its socket, until it is open: with TLS that takes a handshake.
    """

    __slots__ = ("_heads", "address", "unopened")

    def __init__(self, manager: web.Server, heads: HeaderTimeouts, address: str, **options: Any) -> None:
        super().__init__(manager, **options)
        self._heads = heads
        self.address = address
        self.unopened: socket.socket | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin: the transport has the socket from here on."""
        self.unopened = None
        super().connection_made(transport)

    def data_received(self, data: bytes) -> None:
        """Take what has come, if so much may."""
        if self._heads.takes(self, len(data)):
            super().data_received(data)

    def connection_lost(self, exc: BaseException | None) -> None:
        """End; nothing more is waited for."""
        self._heads.leave(self)
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
