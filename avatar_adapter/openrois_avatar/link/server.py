"""The adapter's side of the engine link: it listens, and has at most one engine at a time.

async with LinkServer.listen() as server:           # a Unix socket in a private directory
    engine = await server.accept(timeout=10)        # server.address and server.secret went to the engine
    engine.send_command(React("1", "nod"))
    async with server.video.open() as pictures: ...
"""

from __future__ import annotations

import asyncio
import logging
import secrets
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from typing import Final

from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.source.source import RawAudio

from openrois_avatar.link.connection import FAREWELL_TIMEOUT, EngineConnection
from openrois_avatar.link.encoded_source import EngineEncoded
from openrois_avatar.link.listening import BACKLOG, listening
from openrois_avatar.link.messages import Event, Hello
from openrois_avatar.link.picture_demand import PictureDemand
from openrois_avatar.link.picture_source import EngineVideo
from openrois_avatar.link.receivers import Receivers

GREETING_TIMEOUT: Final = 5.0
"""Seconds from the connection to its HELLO."""
MAX_STRANGERS: Final = BACKLOG
"""Connections without HELLO; one more is refused."""

ACCEPT_PAUSE: Final = 1.0
"""Seconds until the next attempt when connections cannot be accepted, as without free file descriptors."""

_log = logging.getLogger(__name__)


class LinkServer:
    """Listens for engines; made by `listen`.

    An engine needs `address` and `secret`. The sources `video` (a `MediaSource`) and `encoded` (an `EncodingSource`,
    for engines that encode their pictures themselves) outlive the engines, and so does `demand`.
    """

    def __init__(self, secret: str, receivers: Receivers, greeting_timeout: float) -> None:
        self.secret = secret
        self.video = receivers.video
        self.encoded = receivers.encoded
        self.demand = receivers.demand
        self.address = ""
        self._receivers = receivers
        self._greeting_timeout = greeting_timeout
        self._connections: set[EngineConnection] = set()
        self._engine: EngineConnection | None = None
        self._arrived: asyncio.Queue[EngineConnection] = asyncio.Queue(maxsize=1)

    @classmethod
    @asynccontextmanager
    async def listen(
        cls,
        address: str | None = None,
        secret: str | None = None,
        *,
        on_audio: Callable[[RawAudio], None] | None = None,
        on_event: Callable[[Event], None] | None = None,
        on_hello: Callable[[Hello], None] | None = None,
        on_gone: Callable[[str], None] | None = None,
        clock: MediaClock | None = None,
        greeting_timeout: float = GREETING_TIMEOUT,
    ) -> AsyncIterator[LinkServer]:
        """Listen for as long as the context lasts; leaving it sends BYE to the engine and takes half a second.

        Args:
            address: `unix:/path` or `tcp:host:port` on a loopback address (port 0: a free one); without it a Unix
                socket in a directory of its own that only this user may enter.
            secret: that an engine has to send; empty: any will do; None: a random one.
            on_audio: gets the engine's blocks of sound.
            on_event: gets the engine's events.
            on_hello: gets the HELLO of each welcome engine, before anything else of it.
            on_gone: gets the reason when it is disconnected, before anything of another one.
            clock: the media clock; the machine's if not given.
            greeting_timeout: seconds that an engine has for its HELLO.

        Raises:
            LinkError: the address is malformed, not of this machine alone, or cannot be listened on.
        """
        clock = clock or SystemClock()
        demand = PictureDemand(clock)
        video, encoded = EngineVideo(clock, demand), EngineEncoded(clock, demand)
        receivers = Receivers(clock, video, encoded, demand, on_audio, on_event, on_hello, on_gone)
        server = cls(secrets.token_urlsafe(32) if secret is None else secret, receivers, greeting_timeout)
        with listening(address) as (listener, server.address):
            accepting = asyncio.create_task(server._accept_all(listener), name="engine link")
            try:
                yield server
            finally:
                accepting.cancel()
                await asyncio.wait({accepting})
                await server._dismiss()

    @property
    def engine(self) -> EngineConnection | None:
        """The engine that is connected now."""
        return self._engine

    async def accept(self, timeout: float | None = None) -> EngineConnection:
        """Wait for the next engine. One that has disconnected meanwhile is skipped.

        Raises:
            TimeoutError: none came within `timeout` seconds.
        """
        async with asyncio.timeout(timeout):
            return await self._arrived.get()

    def opened(self, connection: EngineConnection) -> str | None:
        """Implement `Host`."""
        self._connections.add(connection)
        strangers = len(self._connections) - (self._engine is not None)
        return "too many connections have not sent HELLO; try again later" if strangers > MAX_STRANGERS else None

    def greeted(self, connection: EngineConnection) -> str | None:
        """Implement `Host`."""
        if self._engine is not None:
            return "another engine is connected; end it, or start a second adapter for this one"
        self._engine = connection
        self._arrived.put_nowait(connection)
        return None

    def ended(self, connection: EngineConnection) -> None:
        """Implement `Host`."""
        if self._engine is connection:
            self._engine = None
            if not self._arrived.empty():
                self._arrived.get_nowait()

    def gone(self, connection: EngineConnection) -> None:
        """Implement `Host`."""
        self._connections.discard(connection)

    async def _accept_all(self, listener: socket.socket) -> None:
        """Serve every connection.

        Neither `loop.create_server` (Python 3.11) nor `loop.sock_accept` is used: both leave a connection open that
        comes while they are being closed.
        """
        loop, clock = asyncio.get_running_loop(), self._receivers.clock
        while True:
            await _readable(listener)
            try:
                stream, _ = listener.accept()
            except OSError as error:
                _log.warning("engine link: cannot accept a connection: %s", error)
                await clock.sleep_until(clock.now() + ACCEPT_PAUSE)
            else:
                stream.setblocking(False)
                await loop.connect_accepted_socket(self._connection, stream)

    def _connection(self) -> EngineConnection:
        return EngineConnection(self, self.secret, self._receivers, self._greeting_timeout)

    async def _dismiss(self) -> None:
        """Send BYE to every connection and wait until all are closed."""
        with suppress(TimeoutError):
            async with asyncio.timeout(2 * FAREWELL_TIMEOUT):
                for connection in list(self._connections):
                    connection.close("the adapter ends")
                for connection in list(self._connections):
                    await connection.gone()


async def _readable(listener: socket.socket) -> None:
    loop = asyncio.get_running_loop()
    ready = asyncio.Event()
    loop.add_reader(listener, ready.set)
    try:
        await ready.wait()
    finally:
        loop.remove_reader(listener)
