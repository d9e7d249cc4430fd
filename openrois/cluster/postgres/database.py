"""Connections to PostgreSQL: some for calls, and one that stays, over which changes are heard; each comes back."""

import asyncio
import logging
import random
import ssl
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager, contextmanager, suppress
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from openrois.aio.listeners import Listeners
from openrois.aio.tasks import TaskScope
from openrois.cluster.postgres.address import parse_store_url
from openrois.cluster.postgres.schema import migrate
from openrois.errors import StoreUnreachable
from openrois.extras import needing_extra
from openrois.transport.backoff import Backoff

with needing_extra("cluster"):
    import asyncpg

if TYPE_CHECKING:
    from collections.abc import Iterator

    from asyncpg import Connection

__all__ = ["CONNECTIONS", "NOW", "Database"]

_log = logging.getLogger(__name__)

CONNECTIONS: Final = 10
"""Connections for calls of one gateway; one more stays open beside them."""

NOW: Final = "(extract(epoch FROM clock_timestamp()) * 1000)::bigint"
"""The server's clock in epoch milliseconds."""

_OPENING: Final = 2.0
"""Seconds in which a connection is made."""

_CLOSING: Final = 1.0
"""Seconds in which connections say that they end."""

_RELINKING: Final = 0.3
"""Seconds that a call waits where that one is being made again."""

_CHANNEL: Final = "openrois"
"""Where changes are notified."""

_LONGEST_PASSWORD: Final = 4096

_SETTINGS: Final = {
    # What a gateway does not wait for any more ends at the server too.
    "statement_timeout": "1000",
    "lock_timeout": "1000",
    "idle_in_transaction_session_timeout": "5000",
    "default_transaction_isolation": "read committed",
    # What was confirmed outlives the server's next second, whatever the server's own setting is.
    "synchronous_commit": "on",
}


class Database(AbstractAsyncContextManager["Database"]):
    """A database that gateways share. Enter it as long as the gateway runs.

    On entering, its schema is made, or migrated to the version of this program; a newer one stays. A connection that is
    lost is made again, and nothing that was under way is repeated over the new one.

    Args:
        url: where it is, as `parse_store_url` has it; without a password.
        password_file: a file with the password alone. It is read for each connection, so that a new password needs no
            restart. None: none is needed, or libpq's own file has it.
        gateway_id: of this gateway; the server's list of connections shows it.
        sleep: waits for some seconds.
        chance: a number from 0 up to 1.

    Attributes:
        name: of hosts and database, for sentences.

    Raises:
        ValueError: the URL is wrong, or the file cannot be read.
        StoreUnreachable: on entering: the database is not there.
        StoreUnusable: on entering: its schema is newer than this program can read.
    """

    def __init__(
        self,
        url: str,
        password_file: Path | None = None,
        *,
        gateway_id: str = "",
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        chance: Callable[[], float] = random.random,
    ) -> None:
        address = parse_store_url(url, ssl.get_default_verify_paths().cafile or "")
        if password_file is not None:
            _read_password(password_file)
        self.name = address.name
        self._connect = partial(
            asyncpg.connect,
            address.url,
            password=None if password_file is None else partial(_read_password, password_file),
            timeout=_OPENING,
            server_settings={**_SETTINGS, "application_name": f"openrois {gateway_id}".strip()[:63]},
        )
        self._sleep = sleep
        self._chance = chance
        self._free = asyncio.Semaphore(CONNECTIONS)
        self._idle: list[Connection] = []
        self._link: Connection | None = None
        self._is_linked = asyncio.Event()
        self._link_use = asyncio.Lock()
        self._failure = ""
        self._topics: dict[str, Listeners[str | None]] = {}
        self._stack = AsyncExitStack()

    async def __aenter__(self) -> Self:
        async with AsyncExitStack() as stack:
            stack.push_async_callback(self._close_idle)
            async with self.connection() as connection:
                await migrate(connection)
            tasks = await stack.enter_async_context(TaskScope())
            tasks.start(self._keep_linked())
            await self._linked(_OPENING)
            self._stack = stack.pop_all()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._stack.aclose()

    @asynccontextmanager
    async def connection(self) -> "AsyncIterator[Connection]":
        """Yield a connection for one call. How long that may take is the caller's to bound.

        One that fails, or whose call is given up, is cut, and so are those that are idle: they may be dead likewise.

        Raises:
            StoreUnreachable: there is none, or what was asked over it failed; it may have been done.
        """
        with self._explained():
            async with self._free:
                connection = await self._borrow()
                try:
                    yield connection
                except BaseException:
                    for each in (connection, *self._idle):
                        each.terminate()
                    self._idle.clear()
                    raise
                self._idle.append(connection)

    @asynccontextmanager
    async def link(self) -> "AsyncIterator[Connection]":
        """Yield the connection that stays open, for what calls must not delay. Where it fails it is made again.

        Raises:
            StoreUnreachable: there is none, or what was asked over it failed; it may have been done.
        """
        with self._explained():
            async with self._link_use:
                connection = await self._linked(_RELINKING)
                try:
                    yield connection
                except BaseException:
                    connection.terminate()
                    raise

    def listen(self, topic: str, listener: Callable[[str | None], None]) -> Callable[[], None]:
        """Call `listener` with what is notified on a topic, and with None whenever something may have been missed.

        A notification has a topic, a blank, and a text: `pg_notify('openrois', 'owner kachaka')`.

        Returns:
            A function that ends that.
        """
        return self._topics.setdefault(topic, Listeners()).add(listener)

    async def _open(self) -> "Connection":
        try:
            return await self._connect()
        except ssl.SSLError:
            # Some of them are a ValueError as well.
            raise
        except (ValueError, asyncpg.ClientConfigurationError) as error:
            # A wrong URL, or a password file that is gone.
            raise StoreUnreachable(f"{self.name}: {error}") from None

    async def _borrow(self) -> "Connection":
        while self._idle:
            connection = self._idle.pop()
            if not connection.is_closed():
                return connection
        return await self._open()

    async def _close_idle(self) -> None:
        for connection in self._idle:
            await _close(connection)
        self._idle.clear()

    # The connection that stays.

    async def _linked(self, patience: float) -> "Connection":
        if self._link is not None and self._link.is_closed():
            # What watches over it was not told yet.
            self._link = None
            self._is_linked.clear()
        if self._link is None:
            with suppress(TimeoutError):
                async with asyncio.timeout(patience):
                    await self._is_linked.wait()
        if self._link is None:
            raise StoreUnreachable(self._failure or f"{self.name} is not connected")
        return self._link

    async def _keep_linked(self) -> None:
        backoff = Backoff(first=0.1, factor=2.0, limit=2.0, lasting=5.0)
        clock = asyncio.get_running_loop().time
        while True:
            began = clock()
            try:
                with self._explained():
                    await self._hold_link()
                self._failure = f"{self.name}: the connection was lost"
            except StoreUnreachable as error:
                self._failure = str(error)
            delay = backoff.after(clock() - began) * (0.5 + self._chance() / 2)
            _log.debug("%s; it is made again in %.1f s", self._failure, delay)
            await self._sleep(delay)

    async def _hold_link(self) -> None:
        """Connect, and return when the connection is lost."""
        connection = await self._open()
        ended = asyncio.Event()
        try:
            connection.add_termination_listener(lambda _connection: ended.set())
            await connection.add_listener(_CHANNEL, self._pass_on)
            self._link = connection
            self._is_linked.set()
            for listeners in self._topics.values():
                listeners.notify_all(None)
            await ended.wait()
        finally:
            self._link = None
            self._is_linked.clear()
            # Where the server went away, the others are dead as well.
            for each in self._idle:
                each.terminate()
            self._idle.clear()
            await _close(connection)

    def _pass_on(self, _connection: object, _process: int, _channel: str, payload: object) -> None:
        topic, _, text = str(payload).partition(" ")
        if topic in self._topics:
            self._topics[topic].notify_all(text)

    @contextmanager
    def _explained(self) -> "Iterator[None]":
        """Raise what goes wrong at the server, or on the way to it, as what it means here."""
        try:
            yield
        except TimeoutError:
            raise StoreUnreachable(f"{self.name} did not answer in time") from None
        except ssl.SSLCertVerificationError as error:
            raise StoreUnreachable(f"{self.name}: its certificate is not trusted: {error.verify_message}") from None
        except (OSError, asyncpg.PostgresError, asyncpg.InterfaceError, asyncpg.InternalClientError) as error:
            raise StoreUnreachable(f"{self.name}: {' '.join(str(error).split())}") from None


async def _close(connection: "Connection") -> None:
    """End a connection, with a word to the server where that takes it in."""
    with suppress(OSError, asyncpg.PostgresError, asyncpg.InterfaceError):
        await connection.close(timeout=_CLOSING)
    connection.terminate()


def _read_password(path: Path) -> str:
    """Return the password that a file holds.

    Raises:
        ValueError: it cannot be read, or is no password; the message names the file and never what is in it.
    """
    try:
        with path.open("rb") as file:
            text = file.read(_LONGEST_PASSWORD + 1).decode().strip()
    except OSError as error:
        raise ValueError(f"the password of the store, {path}, cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path} is no password: it is not plain text") from None
    if not 0 < len(text) <= _LONGEST_PASSWORD:
        raise ValueError(f"{path} is no password: it is empty, or has more than {_LONGEST_PASSWORD} characters")
    return text
