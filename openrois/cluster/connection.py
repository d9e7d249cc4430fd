"""One connection to a NATS server until it is lost: it is never mended, and keeps nothing for later."""

import asyncio
import logging
import socket
import struct
from collections.abc import Callable
from contextlib import suppress
from typing import Final, Self

from openrois.aio.tasks import Deadline
from openrois.cluster.handshake import Opened, open_connection
from openrois.cluster.settings import NatsSettings
from openrois.cluster.wire import ServerParser, WireFault, publication, subscription

__all__ = ["NatsConnection"]

_log = logging.getLogger(__name__)

WRITE_BUFFER: Final = 256 << 10
"""Bytes that may wait in front of the kernel before senders wait, too: signs of life wait behind them."""

_UNSENT: Final = 128 << 10
"""Bytes that may wait in the kernel for their turn on the network, where the system lets that be chosen."""

_MOST: Final = 64 << 20
"""Bytes of a message from the server; it takes at most as many as it is set to."""

_FLUSH_TIMEOUT: Final = 1.0
_RESET: Final = struct.pack("ii", 1, 0)
"""Lets a socket end at once, and drop what the kernel has not sent."""

_ERRORS_THAT_END_NOTHING: Final = (b"permissions violation", b"invalid subject")

Receiver = Callable[[bytes, bytes, bytes], None]
"""Gets subject, headers (empty for none) and payload of a message; it must not raise."""


class NatsConnection(asyncio.Protocol):
    """An open connection.

    Attributes:
        server: its address.
        version: of the server's program, as it says.
        max_payload: bytes of a message that the server takes.
        lost: is set when it has ended.
        reason: why it has ended.
    """

    def __init__(self, on_lost: Callable[[str], None] = lambda _reason: None) -> None:
        self._on_lost = on_lost
        self._parser = ServerParser(self._handle_message, self._handle_line, _MOST)
        self._receivers: dict[int, Receiver] = {}
        self._writable = asyncio.Event()
        self._writable.set()
        self._pongs: list[asyncio.Future[None]] = []
        self._opened: Opened | None = None
        self.server = self.version = ""
        self.max_payload = 0
        self.lost = asyncio.Event()
        self.reason = ""

    @classmethod
    async def open(
        cls, settings: NatsSettings, server: str, name: str, on_lost: Callable[[str], None] = lambda _reason: None
    ) -> Self:
        """Dial a server.

        Args:
            settings: what is shown to it.
            server: its address.
            name: under which the server lists the connection.
            on_lost: called with the reason when the connection ends.

        Raises:
            Unreachable: it does not answer, or does not admit this gateway.
        """
        made = cls(on_lost)
        opened = await open_connection(settings, server, name, made)
        made._opened, made.server, made.version = opened, opened.server, opened.version
        made.max_payload = opened.max_payload
        opened.transport.set_write_buffer_limits(high=WRITE_BUFFER)
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            made._set_option(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, _UNSENT)
        made.data_received(opened.rest)
        return made

    def data_received(self, data: bytes) -> None:
        """Read what the server sent."""
        try:
            self._parser.feed(data)
        except WireFault as fault:
            self.abort(f"NATS cannot be understood: {fault}")

    def _handle_message(self, sid: int, subject: bytes, headers: bytes, payload: bytes) -> None:
        receiver = self._receivers.get(sid)
        if receiver is not None:
            receiver(subject, headers, payload)

    def _handle_line(self, line: bytes) -> None:
        if line == b"PING":
            self._write(b"PONG\r\n")
        elif line == b"PONG":
            if self._pongs and not (pong := self._pongs.pop(0)).done():
                pong.set_result(None)
        elif line.startswith(b"-ERR"):
            said = line[4:200].decode(errors="replace").strip()
            if any(each in line.lower() for each in _ERRORS_THAT_END_NOTHING):
                _log.error("NATS at %s refuses: %s", self.server, said)
            else:
                self.abort(f"NATS ended the connection: {said}")

    def connection_lost(self, exc: Exception | None) -> None:
        """Note that the connection has broken."""
        self._lose(f"the connection to NATS was lost: {exc}" if exc else "NATS has gone")

    def pause_writing(self) -> None:
        """Let senders wait."""
        self._writable.clear()

    def resume_writing(self) -> None:
        """Let senders go on."""
        self._writable.set()

    @property
    def is_open(self) -> bool:
        """Whether it has not ended."""
        return not self.lost.is_set()

    @property
    def is_writable(self) -> bool:
        """Whether what is published now leaves before long."""
        return self._writable.is_set() and not self.lost.is_set()

    async def writable(self) -> None:
        """Wait until what is published leaves before long, or the connection has ended."""
        await self._writable.wait()

    def subscribe(self, subject: str, receiver: Receiver, group: str = "") -> None:
        """Receive what is published to a subject; of a group, one receiver gets each message."""
        sid = len(self._receivers) + 1
        self._receivers[sid] = receiver
        self._write(subscription(subject, sid, group))

    def publish(self, subject: str, payload: bytes, reply: str = "") -> None:
        """Publish a message; of a connection that has ended nothing leaves any more."""
        self._write(publication(subject, payload, reply))

    def _write(self, data: bytes) -> None:
        if self._opened is not None and not self.lost.is_set():
            self._opened.transport.write(data)

    async def flush(self) -> bool:
        """Wait until the server has read what was published, for at most a second, and tell whether it has."""
        if not self.is_open:
            return False
        pong: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._pongs.append(pong)
        self._write(b"PING\r\n")
        with suppress(TimeoutError), Deadline(_FLUSH_TIMEOUT):
            await pong
        return self.is_open and not pong.cancelled()

    def abort(self, reason: str) -> None:
        """End at once: what has not left never leaves."""
        if self._opened is not None and self.is_open:
            self._set_option(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
            self._opened.transport.abort()
        self._lose(reason)

    def _set_option(self, level: int, name: int, value: int | bytes) -> None:
        assert self._opened is not None
        with suppress(OSError):
            self._opened.transport.get_extra_info("socket").setsockopt(level, name, value)

    def _lose(self, reason: str) -> None:
        if self.lost.is_set():
            return
        self.reason = reason
        self.lost.set()
        self._writable.set()
        for pong in self._pongs:
            if not pong.done():
                pong.set_result(None)
        self._on_lost(reason)
