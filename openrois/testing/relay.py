"""A bad connection for tests: a TCP relay that cuts, goes half open, delays, throttles and chops what passes."""

import asyncio
import random
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Final, Self
from urllib.parse import urlsplit

from openrois.aio.tasks import TaskScope

__all__ = ["FaultRelay", "Weather"]

MAX_CONNECTIONS: Final = 4096
"""Connections at a time; one more is reset."""

_READ: Final = 64 << 10
_WAITING: Final = 64
"""Pieces of one direction that wait for their time; while they do, nothing more is read."""
_LOCAL: Final = "127.0.0.1"


@dataclass(frozen=True, slots=True)
class Weather:
    """Impairments of a relay, in both directions. Bytes stay in order and whole.

    Attributes:
        delay: seconds that each piece travels.
        jitter: seconds that it travels longer at most, by chance.
        rate: bytes a second of each direction of each connection; 0 for no bound.
        chop: bytes that are written at once at most, by chance fewer; 0 for as they come.
    """

    delay: float = 0.0
    jitter: float = 0.0
    rate: float = 0.0
    chop: int = 0


class FaultRelay:
    """A TCP relay on this machine in front of a server; enter it, and connect to `url` instead.

    Args:
        target: the server's address, with any path: `http://127.0.0.1:8765/`, `ws://127.0.0.1:8765/adapter`.
        seed: the same seed chops and delays the same bytes alike.
        weather: what it does to bytes at first.
        clock: monotonic seconds.
        sleep: waits for some seconds.

    Attributes:
        weather: what it does to bytes from now on; may be replaced at any time.
        accepted: how many connections there were.
        swallowed: how many bytes went nowhere.
    """

    def __init__(
        self,
        target: str,
        *,
        seed: int = 0,
        weather: Weather | None = None,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        parts = urlsplit(target)
        if parts.hostname is None or parts.port is None:
            raise ValueError(f"{target!r} names no host and port")
        self.weather = weather or Weather()
        self.accepted = 0
        self.swallowed = 0
        self._target = parts
        self._address = parts.hostname, parts.port
        self._clock = clock
        self._sleep = sleep
        self._chance = random.Random(seed)  # noqa: S311 - chance that repeats is the point
        self._deaf = False
        self._refusing = False
        self._connections: set[_Connection] = set()
        self._tasks = TaskScope()
        self._server: asyncio.Server | None = None

    async def __aenter__(self) -> Self:
        await self._tasks.__aenter__()
        self._server = await asyncio.start_server(self._accept, _LOCAL, 0, backlog=1024)
        return self

    async def __aexit__(self, *_error: object) -> None:
        if self._server is not None:
            self._server.close()
        self.cut()
        await self._tasks.__aexit__(None, None, None)

    @property
    def port(self) -> int:
        """The port that it listens on."""
        if self._server is None:
            raise RuntimeError("the relay has not been entered")
        port: int = self._server.sockets[0].getsockname()[1]
        return port

    @property
    def url(self) -> str:
        """The target's address with the relay's in its place."""
        return self._target._replace(netloc=f"{_LOCAL}:{self.port}").geturl()

    def __len__(self) -> int:
        """Return how many connections pass through it now."""
        return len(self._connections)

    def cut(self, *, refuse: bool = False) -> None:
        """Reset every connection, at both ends and at once; the next one passes.

        Args:
            refuse: later ones are reset, too, until `mend`.
        """
        self._refusing = refuse
        for connection in tuple(self._connections):
            connection.abort()

    def half_open(self) -> None:
        """Pull the cable: of what is sent on present and later connections nothing arrives, not even their end.

        Both ends still think that they are connected. `mend` lets later connections pass; these are lost.
        """
        self._deaf = True
        for connection in self._connections:
            connection.deaf = True

    def mend(self) -> None:
        """Let connections pass from now on; those that were half open stay so."""
        self._deaf = self._refusing = False

    def change(self, **weather: Any) -> None:
        """Change some of the weather, from the next piece on."""
        self.weather = replace(self.weather, **weather)

    async def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._refusing or len(self._connections) >= MAX_CONNECTIONS:
            writer.transport.abort()
            return
        self.accepted += 1
        connection = _Connection(self._deaf, [writer])
        self._connections.add(connection)
        self._tasks.start(self._relay(connection, reader, writer))

    async def _relay(
        self, connection: "_Connection", reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        try:
            there_reader, there_writer = await asyncio.open_connection(*self._address)
            connection.writers.append(there_writer)
            async with asyncio.TaskGroup() as ways:
                for source, sink in ((reader, there_writer), (there_reader, writer)):
                    pieces: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue(_WAITING)
                    ways.create_task(self._read_direction(connection, source, pieces))
                    ways.create_task(self._give(connection, pieces, sink))
        except* OSError:
            # The server refuses, or one end broke: either ends both.
            pass
        finally:
            connection.abort()
            self._connections.discard(connection)

    async def _read_direction(
        self, connection: "_Connection", source: asyncio.StreamReader, pieces: asyncio.Queue[tuple[float, bytes]]
    ) -> None:
        """Read one direction until it ends; its end is a piece without bytes."""
        due = 0.0
        while True:
            data = await source.read(_READ)
            if connection.deaf:
                self.swallowed += len(data)
                if not data:
                    await asyncio.Event().wait()
                continue
            weather = self.weather
            late = weather.delay + weather.jitter * self._chance.random()
            due = max(due, self._clock() + late)
            for piece in self._chopped(data, weather.chop):
                due += len(piece) / weather.rate if weather.rate else 0.0
                await pieces.put((due, piece))
            if not data:
                await pieces.put((due, b""))
                return

    def _chopped(self, data: bytes, most: int) -> list[bytes]:
        if not most:
            return [data] if data else []
        pieces = []
        while data:
            length = self._chance.randint(1, most)
            pieces.append(data[:length])
            data = data[length:]
        return pieces

    async def _give(
        self, connection: "_Connection", pieces: asyncio.Queue[tuple[float, bytes]], sink: asyncio.StreamWriter
    ) -> None:
        while True:
            due, piece = await pieces.get()
            if (wait := due - self._clock()) > 0:
                await self._sleep(wait)
            if connection.deaf:
                self.swallowed += len(piece)
                continue
            if not piece:
                # uvloop raises a RuntimeError where the transport has closed.
                with suppress(OSError, RuntimeError):
                    sink.write_eof()
                return
            sink.write(piece)
            await sink.drain()


@dataclass(eq=False, slots=True)
class _Connection:
    deaf: bool
    writers: list[asyncio.StreamWriter]

    def abort(self) -> None:
        for writer in self.writers:
            writer.transport.abort()
