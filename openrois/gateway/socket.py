"""The server's side of a WebSocket as a message stream, on aiohttp."""

import asyncio
import secrets
import struct
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, cast

from aiohttp import WebSocketError, WSCloseCode, WSMessage, WSMsgType, web

from openrois.aio.rate import RateLimit
from openrois.gateway.admission import SUBPROTOCOL
from openrois.gateway.stalling import Stalling
from openrois.http_limits.http_connection import HttpConnection
from openrois.http_limits.websocket_frames import BROKEN, CONTROL_FRAMES_AT_ONCE, CONTROL_FRAMES_PER_SECOND, FrameRules
from openrois.transport.silence import Silence
from openrois.transport.stream import StreamClosed, close_reason

__all__ = ["ADAPTER", "APPLICATION", "ServerSocket", "SocketProfile"]


@dataclass(frozen=True, slots=True)
class SocketProfile:
    """The bounds of one kind of connection.

    Attributes:
        max_message: bytes of one incoming message; a longer one ends the connection with 1009.
        ping_interval: seconds between pings.
        ping_timeout: seconds after a ping within which something has to come, or the connection is cut.
    """

    max_message: int
    ping_interval: float
    ping_timeout: float


APPLICATION: Final = SocketProfile(max_message=64 << 10, ping_interval=4.0, ping_timeout=5.0)
ADAPTER: Final = SocketProfile(max_message=1 << 20, ping_interval=1.5, ping_timeout=3.0)

WRITE_BUFFER: Final = 4096
"""Bytes of one connection that may wait in front of the kernel without counting as unread."""

_CLOSE_TIMEOUT: Final = 1.0
_NO_CODE: Final = 1005

_PING: Final = bytes((0x89, 16))
"""The header of a ping that says 16 bytes."""

_TEXT: Final = 0x81
_LENGTH_16: Final = struct.Struct("!BBH")
_LENGTH_64: Final = struct.Struct("!BBQ")


class ServerSocket:
    """One accepted connection; a `MessageStream` that pings by itself while it is received from.

    Args:
        request: that for the upgrade.
        profile: the bounds of its kind.
        stalling: what it takes in.
        clock: monotonic seconds.
        on_cut: called with the reason when the other side is cut because it stays silent, or takes nothing in.
    """

    def __init__(
        self,
        request: web.Request,
        profile: SocketProfile,
        *,
        stalling: Stalling | None = None,
        clock: Callable[[], float] = time.monotonic,
        on_cut: Callable[[str], None] = lambda _reason: None,
    ) -> None:
        # aiohttp's limit excludes the number itself.
        self.response = web.WebSocketResponse(
            autoping=False,
            compress=False,
            max_msg_size=profile.max_message + 1,
            timeout=_CLOSE_TIMEOUT,
            protocols=(SUBPROTOCOL,),
            writer_limit=0,
        )
        self._request = request
        self._profile = profile
        self._rules = FrameRules(RateLimit(CONTROL_FRAMES_AT_ONCE, CONTROL_FRAMES_PER_SECOND, time.monotonic))
        self._silence = Silence()
        self._stalling = stalling or Stalling()
        self._clock = clock
        self._on_cut = on_cut
        self._pinged = b""
        self._ended: StreamClosed | None = None

    @property
    def _connection(self) -> HttpConnection:
        return cast(HttpConnection, self._request.protocol)

    async def prepare(self) -> None:
        """Answer the upgrade.

        Raises:
            StreamClosed: the client has gone.
        """
        self._connection.rules = self._rules
        try:
            await self.response.prepare(self._request)
        except ConnectionError as error:
            raise StreamClosed(1006) from error
        if self._request.transport is not None:
            # What waits in front of the kernel beyond that keeps its sender waiting, and counts as unread.
            self._request.transport.set_write_buffer_limits(high=WRITE_BUFFER)

    async def keep_alive(self) -> None:
        """Ping for ever. A side that stays silent after a ping, or takes no byte for too long, is cut off.

        It may not read a close frame either.
        """
        while True:
            await asyncio.sleep(self._profile.ping_interval)
            transport = self._request.transport
            if transport is not None and self._stalling.is_over(self._clock(), transport.get_write_buffer_size()):
                self._cut("takes nothing in")
                return
            if await self._silence.follows(self._ping, self._profile.ping_timeout):
                self._cut("no answer to a ping")
                return

    def _cut(self, reason: str) -> None:
        self._on_cut(reason)
        self.abort()

    async def _ping(self) -> None:
        """Ping without waiting: in aiohttp all waiting writers share a future, and a timeout of one cancels all.

        What a ping says comes back in its pong (RFC 6455, 5.5.3), and is known only to a side that has read it.
        """
        self._pinged = secrets.token_bytes(16)
        transport = self._request.transport
        if transport is not None and not self.response.closed and not transport.is_closing():
            self._write(transport, _PING + self._pinged)

    def _write(self, transport: asyncio.WriteTransport, data: bytes) -> None:
        self._stalling.written += len(data)
        transport.write(data)

    async def receive(self) -> str:
        """Return the next text message; a binary one ends the connection with 1003, a wrong frame with its code."""
        self._silence.reading = True
        try:
            while True:
                message = await self.response.receive()
                if message.type is not WSMsgType.PONG or message.data == self._pinged:
                    self._silence.received.set()
                if message.type is WSMsgType.TEXT:
                    text: str = message.data
                    return text
                if message.type is WSMsgType.PING:
                    # A client that sends requests and reads no answers is as silent as one that does not answer.
                    await self._pong(message.data)
                elif message.type is WSMsgType.BINARY:
                    await self._refuse(WSCloseCode.UNSUPPORTED_DATA, "text messages only")
                elif message.type is not WSMsgType.PONG:
                    raise self._closed_by(message)
                elif self._rules.fault is not None and message.data == BROKEN:
                    await self._refuse(self._rules.fault.code, self._rules.fault.reason)
        finally:
            self._silence.reading = False

    async def _refuse(self, code: int, reason: str) -> None:
        await self.close(code, reason)
        raise StreamClosed(code, reason)

    async def _pong(self, data: bytes) -> None:
        try:
            await self.response.pong(data)
        except ConnectionError as error:
            raise StreamClosed(1006) from error

    def _closed_by(self, message: WSMessage) -> StreamClosed:
        """Return how the connection ended; aiohttp reports a lost one as closed in good order."""
        if message.type is WSMsgType.CLOSE:
            return StreamClosed(message.data or _NO_CODE, str(message.extra or ""))
        if isinstance(message.data, WebSocketError):
            return StreamClosed(message.data.code, str(message.data))
        return self._ended or StreamClosed(1006)

    async def send(self, text: str) -> None:
        """Send one text message; waits while the other side is slow."""
        try:
            await self.response.send_str(text)
            self._stalling.written += len(text)
        except ConnectionError as error:
            raise StreamClosed(self.response.close_code or 1006) from error

    def send_now(self, text: str) -> bool:
        """Send one text message if all before it have left, and tell whether that was so."""
        transport = self._request.transport
        if transport is None or self.response.closed or transport.is_closing() or transport.get_write_buffer_size():
            return False
        self._write(transport, _frame(text.encode()))
        return True

    async def send_many(self, texts: Sequence[str]) -> None:
        """Send text messages with one write; waits while the other side is slow, also for what was sent with it."""
        transport = self._request.transport
        if transport is None or self.response.closed or transport.is_closing():
            raise StreamClosed(self.response.close_code or 1006)
        self._write(transport, b"".join([_frame(text.encode()) for text in texts]))
        await self._connection.writable.wait()

    async def close(self, code: int = 1000, reason: str = "") -> None:
        """Close with the closing handshake, for at most a second, then cut."""
        self._ended = self._ended or StreamClosed(code, reason)
        try:
            # The close frame itself waits for a side that does not read.
            async with asyncio.timeout(_CLOSE_TIMEOUT):
                await self.response.close(code=code, message=close_reason(reason).encode())
        except TimeoutError:
            self.abort()

    def abort(self) -> None:
        """Cut the connection."""
        if self._request.transport is not None:
            self._request.transport.abort()


def _frame(payload: bytes) -> bytes:
    """Return a text message as a server sends it: one frame without a mask (RFC 6455, 5.2)."""
    length = len(payload)
    if length < 126:
        return bytes((_TEXT, length)) + payload
    if length < 1 << 16:
        return _LENGTH_16.pack(_TEXT, 126, length) + payload
    return _LENGTH_64.pack(_TEXT, 127, length) + payload
