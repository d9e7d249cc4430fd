"""A way from one part to another that a test blocks, in either direction, without an end; and opens again, or cuts."""

import asyncio
import ctypes
import os
import socket
import threading
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, suppress
from pathlib import Path
from typing import Final, Protocol

from openrois.aio.tasks import TaskScope
from tests.support.namespaces import Namespace, namespace

__all__ = ["Way", "WayTo", "by_cable", "by_relay"]

_READ: Final = 64 << 10
_NEW_NETWORK: Final = 0x40000000


class Way(Protocol):
    """A way to a server.

    Attributes:
        address: where the server is found at the near end of it, as `host:port`.
    """

    address: str

    def block(self, *, there: bool = True, back: bool = True) -> None:
        """Let nothing pass from now on, also no end: to the server, from it, or both."""
        ...

    def open(self) -> None:
        """Let everything pass again, and first what was sent meanwhile, as TCP does where it has not been given up."""
        ...

    def cut(self) -> None:
        """Reset all connections."""
        ...


WayTo = Callable[[str], AbstractAsyncContextManager[Way]]
"""Makes a way to a server: to `host:port`, or to the path of a Unix socket."""


class _Relay:
    """A relay in this process; connections that are made while it is blocked wait."""

    def __init__(self, target: str, tasks: TaskScope) -> None:
        self.address = ""
        self._target = target
        self._tasks = tasks
        self._there, self._back = asyncio.Event(), asyncio.Event()
        self._writers: set[asyncio.StreamWriter] = set()
        self.open()

    def block(self, *, there: bool = True, back: bool = True) -> None:
        for gate, is_blocked in ((self._there, there), (self._back, back)):
            if is_blocked:
                gate.clear()

    def open(self) -> None:
        self._there.set()
        self._back.set()

    def cut(self) -> None:
        for each in self._writers:
            each.transport.abort()

    def accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._tasks.start(self._serve(reader, writer))

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        pair = [writer]
        self._writers.add(writer)
        try:
            await self._there.wait()
            await self._back.wait()
            far_reader, far_writer = await self._dial()
            pair.append(far_writer)
            self._writers.add(far_writer)
            await asyncio.gather(
                _pass(reader, far_writer, self._there, pair), _pass(far_reader, writer, self._back, pair)
            )
        except OSError:
            # Nothing listens there, or one end was reset: the other one ends likewise.
            pass
        finally:
            for each in pair:
                each.transport.abort()
                self._writers.discard(each)

    async def _dial(self) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        if self._target.startswith("/"):
            return await asyncio.open_unix_connection(self._target)
        host, _, port = self._target.rpartition(":")
        return await asyncio.open_connection(host, int(port))


async def _pass(
    source: asyncio.StreamReader, sink: asyncio.StreamWriter, gate: asyncio.Event, pair: Iterable[asyncio.StreamWriter]
) -> None:
    """Pass on one direction while the gate is open; its end, or its reset, too."""
    while True:
        await gate.wait()
        data: bytes | None
        try:
            data = await source.read(_READ)
        except OSError:
            data = None
        await gate.wait()
        if data is None:
            for each in pair:
                each.transport.abort()
            return
        if sink.transport.is_closing():
            # It was cut, and its own reader ends the pair.
            return
        # uvloop raises a RuntimeError where the transport has closed.
        with suppress(OSError, RuntimeError):
            if not data:
                sink.write_eof()
                return
            sink.write(data)
            await sink.drain()


@asynccontextmanager
async def _relay(target: str, near: socket.socket) -> AsyncIterator[_Relay]:
    async with TaskScope() as tasks:
        made = _Relay(target, tasks)
        host, port = near.getsockname()
        made.address = f"{host}:{port}"
        server = await asyncio.start_server(made.accept, sock=near)
        try:
            yield made
        finally:
            server.close()
            made.cut()


@asynccontextmanager
async def by_relay(target: str) -> AsyncIterator[Way]:
    """Make a way over a relay of this process: what is blocked waits in it."""
    async with _relay(target, socket.create_server(("127.0.0.1", 0))) as made:
        yield made


class _Cable:
    """A relay at the other end of a cable, which is pulled: packets are lost, also those that connect."""

    def __init__(self, relay: _Relay, network: Namespace) -> None:
        self.address = relay.address
        self.cut = relay.cut
        self._network = network

    def block(self, *, there: bool = True, back: bool = True) -> None:
        assert there, "a cable is pulled in both directions"
        assert back, "a cable is pulled in both directions"
        self._network.configure("link", "set", self._network.cable, "down")

    def open(self) -> None:
        self._network.configure("link", "set", self._network.cable, "up")


@asynccontextmanager
async def by_cable(target: str) -> AsyncIterator[Way]:
    """Make a way over a network of its own."""
    with namespace() as network:
        async with _relay(target, _listening_in(network)) as relay:
            yield _Cable(relay, network)


def _listening_in(network: Namespace) -> socket.socket:
    """Return a socket that listens in a network; a socket stays where the thread that made it was."""
    made: list[socket.socket] = []

    def listen() -> None:
        with Path(f"/run/netns/{network.name}").open("rb") as file:
            if ctypes.CDLL(None, use_errno=True).setns(file.fileno(), _NEW_NETWORK):
                error = ctypes.get_errno()
                raise OSError(error, os.strerror(error))
        made.append(socket.create_server((network.there, 0)))

    thread = threading.Thread(target=listen)
    thread.start()
    thread.join()
    return made[0]
