"""The WebSocket server for a game engine that does WebRTC itself: one at a time, on this machine."""

import asyncio
import hmac
import logging
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Final
from urllib.parse import unquote, urlsplit

from aiohttp import WSCloseCode, WSMsgType, web

from openrois.aio.rate import RateLimit
from openrois.aio.tasks import TaskScope
from openrois.auth.loopback import is_loopback
from openrois.observability.http_log import HTTP_LOG
from openrois_avatar.facades.messages.reading import MESSAGE_LIMIT, ProtocolError
from openrois_avatar.facades.streamer import Heard, Streamer, StreamerFactory

__all__ = ["FacadeUnavailable", "StreamerServer"]

_log = logging.getLogger(__name__)

_HEARTBEAT: Final = 5.0
"""Seconds between pings; one that is not answered within half of that ends the connection."""

_OUTBOX: Final = 512
"""Messages that may wait for the game engine to read them."""

_AT_ONCE, _PER_SECOND = 1024, 256.0
"""Messages that it may send: 64 candidates and a description for each of many viewers that come at once."""

_SHUTDOWN_TIMEOUT: Final = 0.5


class FacadeUnavailable(Exception):
    """The address for a game engine cannot be listened on; the text says why."""


class StreamerServer:
    """Awaits a game engine. A violation of the protocol ends its connection, and it may connect again at any moment.

    Args:
        make: makes a `Streamer` of the functions that send it a message and handle its messages.
        hear: called with its messages to its players.
        lost: called with a sentence that says why it has disconnected.
        secret: that the path of its address must be, behind the slash; empty: any will do.
        clock: monotonic seconds.
    """

    def __init__(
        self,
        make: StreamerFactory,
        hear: Callable[[Heard], None],
        lost: Callable[[str], None],
        secret: str,
        clock: Callable[[], float],
    ) -> None:
        self._make = make
        self._hear = hear
        self._lost = lost
        self._secret = secret
        self._clock = clock
        self._streamer: Streamer | None = None
        self._socket: web.WebSocketResponse | None = None

    @property
    def streamer(self) -> Streamer | None:
        """The game engine, if it is connected and ready for players."""
        return self._streamer if self._streamer is not None and self._streamer.ready else None

    @asynccontextmanager
    async def listening(self, host: str, port: int) -> AsyncIterator[str]:
        """Listen for as long as the block runs; yield the URL, with the port that was chosen for 0, without the secret.

        Raises:
            FacadeUnavailable: the port is in use, or the address is not this machine's.
        """
        app = web.Application()
        app.router.add_get("/{path:.*}", self._handle_request)
        app.on_shutdown.append(self._close)
        runner = web.AppRunner(
            app, access_log=None, logger=HTTP_LOG, shutdown_timeout=_SHUTDOWN_TIMEOUT, handler_cancellation=True
        )
        await runner.setup()
        try:
            try:
                await web.TCPSite(runner, host, port).start()
            except OSError as error:
                text = f"--facade: cannot listen on {host}:{port}: {error.strerror or error}"
                raise FacadeUnavailable(text) from error
            chosen = runner.addresses[0][1]
            yield f"ws://{f'[{host}]' if ':' in host else host}:{chosen}/"
        finally:
            await runner.cleanup()

    async def _close(self, _app: web.Application) -> None:
        if self._socket is not None:
            await self._socket.close(code=WSCloseCode.GOING_AWAY)

    async def _handle_request(self, request: web.Request) -> web.StreamResponse:
        self._check(request)
        if self._socket is not None:
            raise web.HTTPServiceUnavailable(text="another game engine is connected; an adapter serves one at a time\n")
        # Some clients expect the subprotocol back that they named, whatever it is.
        named = [each.strip() for each in request.headers.get("Sec-WebSocket-Protocol", "").split(",")][:1]
        socket = web.WebSocketResponse(
            protocols=named, max_msg_size=MESSAGE_LIMIT, heartbeat=_HEARTBEAT, compress=False, timeout=1.0
        )
        if not socket.can_prepare(request):
            raise web.HTTPUpgradeRequired(text="a game engine connects here, by WebSocket\n")
        self._socket = socket
        reason = "it has closed the connection"
        try:
            await socket.prepare(request)
            _log.info("a game engine has connected")
            reason = await self._converse(socket, request) or reason
        finally:
            self._socket = self._streamer = None
            _log.info("the game engine is gone: %s", reason)
            self._lost(reason)
        return socket

    def _check(self, request: web.Request) -> None:
        """Refuse requests of pages of other web sites, and requests without the secret."""
        origin = request.headers.get("Origin")
        if not _names_loopback(f"//{request.host}") or (origin and not _names_loopback(origin)):
            raise web.HTTPForbidden(text="only programs of this machine may connect\n")
        if self._secret and not hmac.compare_digest(unquote(request.raw_path[1:]).encode(), self._secret.encode()):
            raise web.HTTPForbidden(text="the path of the address must be the secret\n")

    async def _converse(self, socket: web.WebSocketResponse, request: web.Request) -> str:
        """Pass messages until the connection ends; return why the adapter ended it, if it did."""
        outbox: asyncio.Queue[str] = asyncio.Queue(_OUTBOX)

        def send(text: str) -> None:
            try:
                outbox.put_nowait(text)
            except asyncio.QueueFull:
                # It does not read: it would not read a close frame either.
                if request.transport is not None:
                    request.transport.abort()

        async def write() -> None:
            while True:
                await socket.send_str(await outbox.get())

        async with TaskScope() as tasks:
            self._streamer = self._make(send, self._hear)
            tasks.start(write())
            self._streamer.begin()
            fault = await self._read(socket, self._streamer)
        if fault:
            await socket.close(code=WSCloseCode.POLICY_VIOLATION, message=fault.encode()[:120])
        return fault

    async def _read(self, socket: web.WebSocketResponse, streamer: Streamer) -> str:
        rate = RateLimit(_AT_ONCE, _PER_SECOND, self._clock)
        async for message in socket:
            if message.type is not WSMsgType.TEXT:
                return "messages must be texts"
            if not rate.admits():
                return f"too many messages: at most {_PER_SECOND:g} a second"
            try:
                streamer.handle_message(message.data)
            except ProtocolError as error:
                return str(error)
        return ""


def _names_loopback(url: str) -> bool:
    try:
        return is_loopback(urlsplit(url if "//" in url else f"//{url}").hostname or "")
    except ValueError:
        return False
