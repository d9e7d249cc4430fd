"""Accepts TCP connections, a few in a turn of the event loop, and starts TLS on them; all count from then on."""

import asyncio
import errno
import logging
import socket
import ssl
from collections.abc import AsyncIterator, Callable
from contextlib import ExitStack, asynccontextmanager
from typing import Final

from openrois.aio.tasks import TaskScope
from openrois.http_limits.header_timeout import HEAD_TIMEOUT, Connection, HeaderTimeouts
from openrois.observability.logs import Tally

__all__ = ["serving_tcp"]

_log = logging.getLogger(__name__)

_BACKLOG: Final = 1024
"""Connections that the kernel keeps for us: all clients of a gateway come back at once when it has restarted."""

ACCEPTED_AT_ONCE: Final = 16
"""Connections that are accepted in one turn of the loop: what was cut is closed before more come, and those that are
there go on with their handshakes meanwhile."""

_NO_RESOURCES: Final = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})

_ACCEPT_AGAIN: Final = 0.01
"""Seconds until another attempt where the system has nothing left for a connection."""

_CUT_TIMEOUT: Final = 1.0


@asynccontextmanager
async def serving_tcp(
    host: str,
    port: int,
    header_timeouts: HeaderTimeouts,
    connection: Callable[[str], Connection],
    context: ssl.SSLContext | None = None,
) -> AsyncIterator[int]:
    """Serve connections while the block runs; yields the port, which was chosen for 0.

    What has become of a connection when its TLS handshake has ended is not this block's: it may outlive it.

    Args:
        host: the address to listen on, or a name that has some.
        port: the TCP port.
        header_timeouts: limits how long the connections of this port may wait for a request header.
        connection: makes one, given the remote address.
        context: what TLS is done with; None for plain TCP.

    Raises:
        OSError: the port is taken, or the address is not this machine's.
    """
    async with TaskScope() as opening:
        accepting = _Accepting(header_timeouts, connection, context, opening)
        try:
            with ExitStack() as stack:
                listening = [stack.enter_context(each) for each in await _listen(host, port)]
                async with TaskScope() as tasks:
                    for each in listening:
                        tasks.start(accepting.run(each))
                    yield int(listening[0].getsockname()[1])
        finally:
            await accepting.cut_unopened()


async def _listen(host: str, port: int) -> list[socket.socket]:
    loop = asyncio.get_running_loop()
    found = await loop.getaddrinfo(host or None, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    listening: list[socket.socket] = []
    try:
        for family, _, _, _, address in dict.fromkeys(found):
            listening.append(socket.create_server(address, family=family, backlog=_BACKLOG))
            listening[-1].setblocking(False)
    except OSError:
        for each in listening:
            each.close()
        raise
    return listening


class _Accepting:
    """Accepts the connections of one port, and opens each: with TLS that takes a handshake."""

    def __init__(
        self,
        header_timeouts: HeaderTimeouts,
        connection: Callable[[str], Connection],
        context: ssl.SSLContext | None,
        opening: TaskScope,
    ) -> None:
        self._header_timeouts = header_timeouts
        self._connection = connection
        self._context = context
        self._opening = opening
        self._unopened: dict[Connection, asyncio.Task[None]] = {}
        self._tally = Tally(_log, "connections that could not be accepted at once", logging.WARNING)

    async def run(self, listening: socket.socket) -> None:
        """Accept connections for ever."""
        loop = asyncio.get_running_loop()
        while True:
            for _ in range(ACCEPTED_AT_ONCE):
                try:
                    # Does not suspend where a connection waits already.
                    near, (address, *_) = await loop.sock_accept(listening)
                except ConnectionError:
                    continue
                except OSError as error:
                    if error.errno not in _NO_RESOURCES:
                        raise
                    await self._make_room(error)
                else:
                    await self._begin(near, address)
            await asyncio.sleep(0)

    async def _make_room(self, error: OSError) -> None:
        self._tally.note(error.strerror or str(error))
        # One that is cut has given back its descriptor some turns of the loop later.
        self._header_timeouts.cut_oldest()
        await asyncio.sleep(_ACCEPT_AGAIN)

    async def _begin(self, near: socket.socket, address: str) -> None:
        try:
            await self._header_timeouts.wait_for_room(address)
        except asyncio.CancelledError:
            near.close()
            raise
        connection = self._connection(address)
        connection.unopened = near
        self._header_timeouts.join(connection)
        self._unopened[connection] = self._opening.start(self._open(near, connection))

    async def _open(self, near: socket.socket, connection: Connection) -> None:
        loop = asyncio.get_running_loop()
        timeout = None if self._context is None else HEAD_TIMEOUT
        try:
            await loop.connect_accepted_socket(
                lambda: connection, near, ssl=self._context, ssl_handshake_timeout=timeout
            )
        except OSError as error:
            _log.debug("no connection with %s: %s", connection.address, error)
            self._header_timeouts.leave(connection)
        finally:
            del self._unopened[connection]

    async def cut_unopened(self) -> None:
        """Cut all connections that are being opened, and wait until these have ended."""
        for connection in self._unopened:
            connection.abort()
        if self._unopened:
            await asyncio.wait(self._unopened.values(), timeout=_CUT_TIMEOUT)
