"""A WebSocket client that sends raw bytes and describes received frames in words."""

import asyncio
import itertools
import json
import socket
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from urllib.parse import urlsplit

CONTINUATION, TEXT, BINARY, CLOSE, PING, PONG = 0, 1, 2, 8, 9, 10


def frame(
    opcode: int,
    payload: bytes = b"",
    *,
    fin: bool = True,
    rsv: int = 0,
    mask: bytes | None = bytes(4),
    form: int | None = None,
    length: int | None = None,
) -> bytes:
    """Return a frame as a client sends it, unless told otherwise.

    Args:
        opcode: what it is.
        payload: what is in it.
        fin: whether it is the last of its message.
        rsv: its three reserved bits, 4 for the first.
        mask: its mask; None for a frame without one.
        form: bytes that the length takes (0, 2 or 8); as few as are enough unless given.
        length: what the header says of the length, if that is not so.
    """
    length = len(payload) if length is None else length
    if form is None:
        form = 0 if length < 126 else 2 if length < 1 << 16 else 8
    second = length if form == 0 else {2: 126, 8: 127}[form]
    head = bytes((fin << 7 | rsv << 4 | opcode, (mask is not None) << 7 | second))
    head += length.to_bytes(form, "big") if form else b""
    if mask is None:
        return head + payload
    return head + mask + bytes(byte ^ mask[index % 4] for index, byte in enumerate(payload))


def request(request_id: int, *, size: int = 0, note: str = "") -> bytes:
    """Return the text of a request that is answered with OK, of `size` bytes if that is more than it needs."""
    asked = {"jsonrpc": "2.0", "id": f"{request_id}{note}", "method": "rois.system.connect"}
    return json.dumps(asked, ensure_ascii=False).encode().ljust(size)


def asks(request_id: int) -> bytes:
    """Return a request in one frame."""
    return frame(TEXT, request(request_id))


def pieces(payload: bytes, *cuts: int) -> bytes:
    """Return a text in fragments, cut at these places."""
    edges = [0, *cuts, len(payload)]
    parts = [payload[start:end] for start, end in itertools.pairwise(edges)]
    last = len(parts) - 1
    return b"".join(frame(CONTINUATION if index else TEXT, part, fin=index == last) for index, part in enumerate(parts))


def closes(code: int, reason: bytes = b"") -> bytes:
    """Return a close frame."""
    return frame(CLOSE, code.to_bytes(2, "big") + reason)


@dataclass
class RawClient:
    """A connection whose handshake is over."""

    reader: asyncio.StreamReader
    writer: asyncio.StreamWriter

    async def send(self, chunks: Sequence[bytes]) -> None:
        """Send each chunk with a write of its own."""
        with suppress(ConnectionError):
            for chunk in chunks:
                self.writer.write(chunk)
                await self.writer.drain()
                if len(chunks) > 1:
                    await asyncio.sleep(0)

    async def hears(self, last: str = "") -> list[str]:
        """Return what comes up to `last`, a close or the end: `answer 1`, `error -32700`, `pong x`, `close 1002`."""
        heard: list[str] = []
        try:
            while not heard or (heard[-1] != last and not heard[-1].startswith("close")):
                if said := await self._next():
                    heard.append(said)
        except (asyncio.IncompleteReadError, ConnectionError):
            heard.append("end")
        return heard

    async def floods(self, chunk: bytes) -> None:
        """Send the same over and over until the connection has ended."""
        with suppress(ConnectionError):
            while not self.reader.at_eof():
                self.writer.write(chunk)
                await self.writer.drain()
                await asyncio.sleep(0)

    async def ends(self) -> bool:
        """Read to the end."""
        with suppress(ConnectionError):
            await self.reader.read()
        return True

    async def _next(self) -> str:
        first, second = await self.reader.readexactly(2)
        assert first & 0x70 == 0
        assert second < 128, "a server masks nothing"
        length = second
        if second > 125:
            length = int.from_bytes(await self.reader.readexactly(2 if second == 126 else 8), "big")
        payload = await self.reader.readexactly(length)
        match first & 0x0F:
            case 1:
                message = json.loads(payload)
                return f"error {message['error']['code']}" if "error" in message else f"answer {message['id']}"
            case 8:
                return f"close {int.from_bytes(payload[:2], 'big')}"
            case 10:
                return f"pong {payload.decode('latin-1')}"
            case 9:  # Its own pings come whenever it likes.
                return ""
        raise AssertionError(f"a frame with opcode {first & 0x0F}")


@asynccontextmanager
async def raw_client(
    url: str, path: str = "", *, with_handshake: bytes = b"", is_small: bool = False
) -> AsyncIterator[RawClient]:
    """Open a WebSocket.

    Args:
        url: the gateway's.
        path: where at the gateway.
        with_handshake: what is sent in one write with the handshake, before it is answered.
        is_small: whether next to nothing is taken in where it is not read.
    """
    place = urlsplit(url)
    near = socket.socket()
    if is_small:
        near.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    near.setblocking(False)
    await asyncio.get_running_loop().sock_connect(near, (place.hostname, place.port))
    reader, writer = await asyncio.open_connection(sock=near, limit=4096 if is_small else 1 << 16)
    try:
        writer.write(
            f"GET /{path} HTTP/1.1\r\nHost: {place.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
            "Sec-WebSocket-Extensions: permessage-deflate\r\n\r\n".encode()
            + with_handshake
        )
        head = await reader.readuntil(b"\r\n\r\n")
        assert head.startswith(b"HTTP/1.1 101"), head
        assert b"extensions" not in head.lower()
        yield RawClient(reader, writer)
    finally:
        # What the other side does not take in any more would wait for ever.
        writer.transport.abort()
        with suppress(ConnectionError):
            await writer.wait_closed()
