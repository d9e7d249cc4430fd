"""A TURN client for any request, one at a time, that returns the error codes (RFC 8656)."""

import asyncio
import hashlib
import hmac
import ipaddress
import os
import struct
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field

COOKIE = struct.pack("!I", 0x2112A442)
ALLOCATE, SEND, CREATE_PERMISSION, CHANNEL_BIND = 0x003, 0x016, 0x008, 0x009
USERNAME, INTEGRITY, ERROR, CHANNEL, PEER, DATA = 0x0006, 0x0008, 0x0009, 0x000C, 0x0012, 0x0013
REALM, NONCE, FAMILY, TRANSPORT = 0x0014, 0x0015, 0x0017, 0x0019
UDP, TCP = 17, 6
OK = 0
PATIENCE = 10.0
REPEATED = 0.5
"""Seconds after which a request is sent again: UDP loses some."""
INVITATIONS = 4
"""Nonces tried for one request: a request that was sent twice is answered with two, of which the first is stale."""


@dataclass
class TurnClient(asyncio.DatagramProtocol):
    """One five-tuple at a TURN server.

    Attributes:
        username: sent with each request; none where it is empty.
        credential: what it proves that with.
    """

    username: str = ""
    credential: str = ""
    realm: bytes = b""
    nonce: bytes = b""
    channel: int = 0x4000
    heard: asyncio.Queue[bytes] = field(default_factory=asyncio.Queue)
    transport: asyncio.DatagramTransport | None = None

    def datagram_received(self, data: bytes, _addr: object) -> None:
        self.heard.put_nowait(data)

    async def allocate(self, *, family: int = 4, transport: int = UDP) -> int:
        """Ask for a relayed address; return 0 or the error code."""
        asked = [(TRANSPORT, bytes((transport, 0, 0, 0)))]
        if family == 6:
            asked.append((FAMILY, b"\x02\0\0\0"))
        return await self.ask(ALLOCATE, *asked)

    async def permit(self, address: str) -> int:
        """Ask that something of an address may pass; return 0 or the error code."""
        return await self.ask(CREATE_PERMISSION, (PEER, address))

    async def bind(self, address: str, port: int = 9) -> int:
        """Ask for a channel to an address; return 0 or the error code."""
        self.channel += 1
        return await self.ask(CHANNEL_BIND, (CHANNEL, struct.pack("!HH", self.channel, 0)), (PEER, (address, port)))

    def send(self, address: str, port: int, data: bytes) -> None:
        """Have data sent to an address, permitted or not; nothing answers that."""
        message, _ = self._message(SEND, [(PEER, (address, port)), (DATA, data)])
        self._write(message)

    async def ask(self, method: int, *attributes: tuple[int, object]) -> int:
        """Ask, again with what the server wants to be proven; return 0 or the error code."""
        for _ in range(INVITATIONS):
            before = self.nonce
            code = await self._ask(method, attributes)
            if code not in {401, 438} or not self.username or self.nonce == before:
                break
        return code

    async def _ask(self, method: int, attributes: tuple[tuple[int, object], ...]) -> int:
        message, transaction = self._message(method, list(attributes))
        answer = b""
        async with asyncio.timeout(PATIENCE):
            while answer[8:20] != transaction:
                self._write(message)
                with suppress(TimeoutError):
                    async with asyncio.timeout(REPEATED):
                        while (answer := await self.heard.get())[8:20] != transaction:
                            pass
        return self._read(answer)

    def _write(self, message: bytes) -> None:
        assert self.transport is not None
        self.transport.sendto(message)

    def _message(self, method: int, attributes: list[tuple[int, object]]) -> tuple[bytes, bytes]:
        transaction = os.urandom(12)
        body = b"".join(_attribute(kind, _value(value, transaction)) for kind, value in attributes)
        proven = bool(self.username and self.nonce and method != SEND)
        if proven:
            body += _attribute(USERNAME, self.username.encode())
            body += _attribute(REALM, self.realm) + _attribute(NONCE, self.nonce)
        head = struct.pack("!HH", method, len(body) + 24 * proven) + COOKIE + transaction
        if proven:
            key = hashlib.md5(f"{self.username}:{self.realm.decode()}:{self.credential}".encode()).digest()
            body += _attribute(INTEGRITY, hmac.digest(key, head + body, "sha1"))
        return head + body, transaction

    def _read(self, answer: bytes) -> int:
        """Keep what an answer says, and return its error code."""
        code, at = OK, 20
        while at < len(answer):
            kind, length = struct.unpack_from("!HH", answer, at)
            value = answer[at + 4 : at + 4 + length]
            at += 4 + length + -length % 4
            if kind == REALM:
                self.realm = value
            elif kind == NONCE:
                self.nonce = value
            elif kind == ERROR:
                code = value[2] * 100 + value[3]
        return code


def _xored(data: bytes, key: bytes) -> bytes:
    return bytes(byte ^ key[index] for index, byte in enumerate(data))


def _value(value: object, transaction: bytes) -> bytes:
    """Return the bytes of a value; an address, with or without a port, is hidden as RFC 8489 has it."""
    if isinstance(value, bytes):
        return value
    host, port = value if isinstance(value, tuple) else (value, 9)
    packed = ipaddress.ip_address(host).packed
    hidden = _xored(struct.pack("!H", port), COOKIE) + _xored(packed, COOKIE + transaction)
    return bytes((0, 1 if len(packed) == 4 else 2)) + hidden


def _attribute(kind: int, value: bytes) -> bytes:
    return struct.pack("!HH", kind, len(value)) + value + bytes(-len(value) % 4)


@asynccontextmanager
async def turn_client(server: tuple[str, int], username: str = "", credential: str = "") -> AsyncIterator[TurnClient]:
    """Open a socket towards a TURN server."""
    client = TurnClient(username, credential)
    loop = asyncio.get_running_loop()
    client.transport, _ = await loop.create_datagram_endpoint(lambda: client, remote_addr=server)
    try:
        yield client
    finally:
        client.transport.close()
