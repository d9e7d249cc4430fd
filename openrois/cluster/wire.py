"""What a NATS server sends, and what is sent to it: the part of its protocol that an open connection needs. Pure."""

from collections.abc import Callable
from typing import Final

__all__ = ["MAX_LINE", "ServerParser", "WireFault", "publication", "subscription"]

MAX_LINE: Final = 64 << 10
"""Bytes of a line; INFO names all servers of a cluster."""

_END: Final = b"\r\n"


class WireFault(Exception):
    """What came is nothing that a NATS server sends."""


class ServerParser:
    """Reads what a server sends.

    Args:
        on_message: called with number of the subscription, subject, headers (empty for none) and payload.
        on_line: called with each other line: `PING`, `PONG`, `INFO {...}`, `-ERR '...'`.
        most: bytes of a message.
    """

    def __init__(
        self, on_message: Callable[[int, bytes, bytes, bytes], None], on_line: Callable[[bytes], None], most: int
    ) -> None:
        self._on_message = on_message
        self._on_line = on_line
        self._most = most
        self._rest = bytearray()
        self._needed = 0

    def feed(self, data: bytes) -> None:
        """Read what came.

        Raises:
            WireFault: it cannot be read, and neither can what follows.
        """
        if self._rest:
            self._rest += data
            if len(self._rest) < self._needed:
                return
            data = bytes(self._rest)
            self._rest.clear()
        at = self._read(data)
        if at < len(data):
            self._rest += data[at:]

    def _read(self, data: bytes) -> int:
        """Read all that is whole; return where the rest begins, and note how much that has to become."""
        at = 0
        while (end := data.find(_END, at)) >= 0:
            line, begin = data[at:end], end + 2
            if not line.startswith((b"MSG ", b"HMSG ")):
                self._on_line(line)
                at = begin
                continue
            sid, subject, headers, size = self._parsed(line)
            end = begin + size
            if len(data) < end + 2:
                self._needed = end + 2 - at
                return at
            if data[end : end + 2] != _END:
                raise WireFault("a message is longer than was said")
            self._on_message(sid, subject, data[begin : begin + headers], data[begin + headers : end])
            at = end + 2
        if len(data) - at > MAX_LINE:
            raise WireFault("a line has no end")
        self._needed = 0
        return at

    def _parsed(self, line: bytes) -> tuple[int, bytes, int, int]:
        """Return subscription, subject, bytes of headers and of all: `HMSG subject sid [reply] head all`, or `MSG`."""
        words = line.split()
        has_headers = line.startswith(b"H")
        if not 4 <= len(words) - has_headers <= 5:
            raise WireFault("a line of a message has too few words, or too many")
        try:
            sid, size = int(words[2]), int(words[-1])
            headers = int(words[-2]) if has_headers else 0
        except ValueError:
            raise WireFault("a number in the line of a message cannot be read") from None
        if not 0 <= headers <= size <= self._most:
            raise WireFault("the lengths of a message cannot be")
        return sid, words[1], headers, size


def publication(subject: str, payload: bytes, reply: str = "") -> bytes:
    """Return what publishes a message."""
    return b"PUB %s %s %d\r\n%s\r\n" % (subject.encode(), reply.encode(), len(payload), payload)


def subscription(subject: str, sid: int, group: str = "") -> bytes:
    """Return what subscribes; of a group, one gets each message."""
    return b"SUB %s %s %d\r\n" % (subject.encode(), group.encode(), sid)
