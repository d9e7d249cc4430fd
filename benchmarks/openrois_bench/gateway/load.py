"""Load of applications that cost next to nothing, so that the gateway is measured and not they."""

import asyncio
import base64
import os
import ssl
import struct
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any, Final
from urllib.parse import urlsplit

from openrois_bench.errors import BenchFailed, within

__all__ = ["Application", "Door", "applications"]

PATIENCE: Final = 240.0
"""Seconds that all connections of a bench have to open."""

AT_ONCE: Final = 32
"""Connections that are opened at a time."""

CLOSING: Final = 2.0
"""Seconds that the gateway has to answer the close frames of all connections; then they are cut."""

_TEXT: Final = 0x81
_CLOSE: Final = 0x88
_PING: Final = 0x89
_PONG: Final = 0x8A
_MASKED: Final = 0x80
# A mask of zeros is a mask to the gateway, which removes it like any other, and nothing to us.
_MASK: Final = bytes(4)
_NORMAL_CLOSURE: Final = struct.pack("!H", 1000)


@dataclass(frozen=True, slots=True)
class Door:
    """The address of a gateway, and the certificates and token for a connection to it.

    Attributes:
        url: as the gateway tells it.
        context: what its certificate is checked with; None for a gateway without TLS.
        token: what to show; empty for a gateway that does not ask.
    """

    url: str
    context: ssl.SSLContext | None = None
    token: str = ""

    def websocket(self) -> dict[str, Any]:
        """Return the same as arguments of the `websockets` library."""
        headers = {"Authorization": f"Bearer {self.token}"} if self.token else {}
        return {"uri": self.url.replace("http", "ws", 1), "ssl": self.context, "additional_headers": headers}


class Application(asyncio.Protocol):
    """One connection of an application.

    Attributes:
        on_message: takes each message as bytes.
        opened: settled once the upgrade is answered.
        closed: set once the connection has ended.
    """

    def __init__(self) -> None:
        self.on_message: Callable[[bytes], None] = lambda _message: None
        self.opened: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self.closed = asyncio.Event()
        self._buffer = b""

    def connection_made(self, transport: Any) -> None:
        """Note the transport."""
        self._transport: asyncio.Transport = transport

    def connection_lost(self, error: Exception | None) -> None:
        """Note the end, and fail the opening where it is still waited for."""
        self.closed.set()
        if not self.opened.done():
            self.opened.set_exception(BenchFailed(f"the gateway ended a connection: {error}"))

    def greet(self, door: Door) -> None:
        """Ask for the upgrade."""
        parts = urlsplit(door.url)
        lines = [
            "GET / HTTP/1.1",
            f"Host: {parts.netloc}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}",
            "Sec-WebSocket-Version: 13",
        ]
        if door.token:
            lines.append(f"Authorization: Bearer {door.token}")
        self._transport.write("\r\n".join([*lines, "", ""]).encode())

    def send(self, payload: bytes) -> None:
        """Send one text message of less than 64 KiB."""
        self._transport.write(_frame(_TEXT, payload))

    @property
    def is_open(self) -> bool:
        """Whether the connection lives."""
        return not self._transport.is_closing()

    def close(self) -> None:
        """Begin the closing handshake; `closed` says when it is over."""
        if self.is_open:
            self._transport.write(_frame(_CLOSE, _NORMAL_CLOSURE))

    def abort(self) -> None:
        """Cut the connection."""
        self._transport.abort()

    def data_received(self, data: bytes) -> None:
        """Take apart what has come."""
        data = self._buffer + data if self._buffer else data
        start = 0 if self.opened.done() else self._upgraded(data)
        while len(data) - start >= 2:
            length, head = data[start + 1], 2
            if length == 126:
                head = 4
                if len(data) - start < head:
                    break
                length = data[start + 2] << 8 | data[start + 3]
            elif length == 127:
                raise BenchFailed("the gateway sent a message that no bench asks for")
            end = start + head + length
            if end > len(data):
                break
            self._handle_frame(data[start], data[start + head : end])
            start = end
        self._buffer = data[start:]

    def _upgraded(self, data: bytes) -> int:
        head, found, _ = data.partition(b"\r\n\r\n")
        if not found:
            return len(data) if not data else 0
        if not head.startswith(b"HTTP/1.1 101"):
            self.opened.set_exception(BenchFailed(f"the gateway answered {head[:80].decode(errors='replace')}"))
        else:
            self.opened.set_result(None)
        return len(head) + 4

    def _handle_frame(self, kind: int, payload: bytes) -> None:
        if kind == _TEXT:
            self.on_message(payload)
        elif kind == _PING:
            self._transport.write(_frame(_PONG, payload))
        elif kind == _CLOSE:
            self._transport.close()


def _frame(kind: int, payload: bytes) -> bytes:
    length = len(payload)
    if length < 126:
        return bytes((kind, _MASKED | length)) + _MASK + payload
    return struct.pack("!BBH", kind, _MASKED | 126, length) + _MASK + payload


@asynccontextmanager
async def applications(door: Door, count: int) -> AsyncIterator[Sequence[Application]]:
    """Hold `count` open connections while the block runs.

    Raises:
        BenchFailed: the gateway refused one, or opened them too slowly.
    """
    parts = urlsplit(door.url)
    loop = asyncio.get_running_loop()
    free = asyncio.Semaphore(AT_ONCE)
    open_ones: list[Application] = []

    async def enter() -> None:
        async with free:
            _, application = await loop.create_connection(
                Application, parts.hostname or "", parts.port or 80, ssl=door.context
            )
            open_ones.append(application)
            application.greet(door)
            await application.opened

    try:
        async with within(PATIENCE, f"opening {count} connections"), asyncio.TaskGroup() as opening:
            for _ in range(count):
                opening.create_task(enter())
        yield open_ones
    finally:
        await _close(open_ones)


async def _close(open_ones: Sequence[Application]) -> None:
    """Close connections in good order, and cut those whose close frame is not answered in time."""
    try:
        for application in open_ones:
            application.close()
        with suppress(TimeoutError):
            async with asyncio.timeout(CLOSING):
                for application in open_ones:
                    await application.closed.wait()
    finally:
        for application in open_ones:
            application.abort()
