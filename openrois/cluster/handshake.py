"""Dials a NATS server with nats-py, and has the open connection from it. Its private names all stand here.

nats-py knows how to authenticate and when to encrypt. What it would do afterwards is unfit for streams: it keeps what
is published while it dials again and sends it later, its queues drop messages, and each message passes through three
tasks.
"""

import asyncio
import ssl
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any, Final

from openrois.cluster.settings import NatsSettings
from openrois.extras import needing_extra

with needing_extra("cluster"):
    from nats.aio.client import Client
    from nats.errors import Error

__all__ = ["Opened", "Unreachable", "open_connection"]

OPEN_TIMEOUT: Final = 2.0
"""Seconds that a server may take to admit this gateway."""

_LONGEST_VERSION: Final = 32


class Unreachable(Exception):
    """A server of NATS could not be dialled; the text says why, and what helps."""


@dataclass(frozen=True, slots=True)
class Opened:
    """A connection that is open and has not been used.

    Attributes:
        server: its address.
        version: of its program, as it says.
        transport: it.
        rest: what came already.
        max_payload: bytes of a message that the server takes.
        keeper: has to be kept for as long as the connection: it closes it when it is forgotten.
    """

    server: str
    version: str
    transport: asyncio.Transport
    rest: bytes
    max_payload: int
    keeper: object


class _Dialler(Client):
    """nats-py's client until the connection is open.

    Args:
        is_encrypted: whether nothing may be said to a server that does not encrypt.
    """

    def __init__(self, *, is_encrypted: bool) -> None:
        super().__init__()
        self._is_encrypted = is_encrypted

    @property
    def said_version(self) -> str:
        """The version that the server says it has."""
        return str(self._server_info.get("version", ""))[:_LONGEST_VERSION]

    async def _process_info(self, info: dict[str, Any], initial_connection: bool = False) -> None:
        """Look at what the server says first: what is said next holds the credentials."""
        if self._is_encrypted and not info.get("tls_required"):
            raise Error("it does not encrypt: let it require TLS, or name it with nats://")
        await super()._process_info(info, initial_connection)

    async def abort(self) -> None:
        """Cut a connection that is not used."""
        if self._transport:
            writer = self._transport._io_writer  # type: ignore[attr-defined]
            writer.transport.abort()
        await self._end_tasks()

    async def _end_tasks(self) -> None:
        working = [self._reading_task, self._ping_interval_task, self._flusher_task]
        if tasks := [task for task in working if task is not None]:
            for task in tasks:
                task.cancel()
            await asyncio.wait(tasks)

    async def hand_over(self, protocol: asyncio.Protocol) -> tuple[asyncio.Transport, bytes]:
        """Give the connection to another protocol; return it with what came meanwhile."""
        assert self._transport is not None
        reader: asyncio.StreamReader = self._transport._io_reader  # type: ignore[attr-defined]
        transport: asyncio.Transport = self._transport._io_writer.transport  # type: ignore[attr-defined]
        transport.set_protocol(protocol)
        # None of its tasks has begun: nothing was awaited since they were made.
        reader.feed_eof()
        rest = await reader.read()
        await self._end_tasks()
        return transport, rest


@asynccontextmanager
async def _dialler(settings: NatsSettings, server: str, name: str) -> AsyncIterator[_Dialler]:
    async def raise_error(error: Exception) -> None:
        raise error

    client = _Dialler(is_encrypted=server.startswith("tls:"))
    shown: dict[str, Any] = {}
    if login := settings.login():
        shown = {"token": login.token} if login.token else {"user": login.user, "password": login.password}
    if server.startswith("tls:") or settings.names_tls:
        shown["tls"] = settings.context()
    task = asyncio.current_task()
    assert task is not None
    asked_to_end = task.cancelling()
    try:
        await client.connect(
            [server],
            error_cb=raise_error,
            name=name,
            allow_reconnect=False,
            connect_timeout=OPEN_TIMEOUT,  # type: ignore[arg-type]
            **shown,
        )
        # nats-py uses `asyncio.wait_for`, which loses a cancellation that comes with its result before Python 3.12.
        if task.cancelling() > asked_to_end:
            raise asyncio.CancelledError
        yield client
    except BaseException:
        await client.abort()
        raise


async def open_connection(settings: NatsSettings, server: str, name: str, protocol: asyncio.Protocol) -> Opened:
    """Dial one server, and let `protocol` have the connection.

    Args:
        settings: what is shown to it.
        server: its address.
        name: under which the server lists the connection.
        protocol: receives what comes after `Opened.rest`; `connection_made` is not called.

    Raises:
        Unreachable: no server answers there, or it does not admit this gateway.
    """
    try:
        async with asyncio.timeout(OPEN_TIMEOUT), _dialler(settings, server, name) as client:
            version, max_payload = client.said_version, client.max_payload
            transport, rest = await client.hand_over(protocol)
    except Exception as error:
        # Whatever answers there may say anything, and nats-py trips over some of it.
        raise Unreachable(f"NATS at {server} is not reached: {_explained(error)}") from None
    return Opened(server, version, transport, rest, max_payload, client)


def _explained(error: Exception) -> str:
    """Return in words why there is no connection; nothing that was shown to the server is repeated."""
    match error:
        case ssl.SSLCertVerificationError():
            return f"its certificate is not trusted: {error.verify_message} (name the authority's file)"
        case TimeoutError():
            return "nothing answers in time"
        case OSError():
            return error.strerror or str(error)
        case Error() if "authorization" in str(error).lower():
            return "it does not admit this gateway (name the file with its credentials)"
        case Error() | ValueError():
            return str(error).removeprefix("nats: ")
    return f"what answers there is no NATS server ({type(error).__name__})"
