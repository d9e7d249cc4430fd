"""A real NATS server on a loopback port, which can be killed, frozen and started again; and streams over it."""

import asyncio
import itertools
import signal
import socket
import subprocess
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

from openrois.cluster.link import NatsLink, NatsSettings, NatsStream
from tests.support.demo import free_port
from tests.support.nats_program import nats_program

__all__ = ["NatsServer", "dialled", "links", "nats_server", "settings"]

PATIENCE = 30.0
"""Seconds that a server may take on a busy machine to begin."""

_clusters = itertools.count()


class NatsServer:
    """The server's process.

    Attributes:
        port: where it listens, also after it was started again.
        url: its address.
    """

    def __init__(self, folder: Path, configuration: str = "", scheme: str = "nats") -> None:
        self.port = free_port()
        self.url = f"{scheme}://127.0.0.1:{self.port}"
        self._process: subprocess.Popen[bytes] | None = None
        self._file = folder / f"nats-{self.port}.conf"
        self._file.write_text(f'host: "127.0.0.1"\nport: {self.port}\n{configuration}\n')

    def start(self) -> None:
        """Start it, and wait until it listens: that takes less time than a heartbeat."""
        program = nats_program()
        assert program is not None
        quiet = subprocess.DEVNULL
        self._process = subprocess.Popen([program, "-c", self._file], stdin=quiet, stdout=quiet, stderr=quiet)
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            time.sleep(0.005)
        raise TimeoutError("the NATS server does not listen")

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def freeze(self) -> None:
        self._send(signal.SIGSTOP)

    def thaw(self) -> None:
        self._send(signal.SIGCONT)

    def _send(self, number: signal.Signals) -> None:
        assert self._process is not None
        self._process.send_signal(number)


@contextmanager
def nats_server(folder: Path, configuration: str = "", scheme: str = "nats") -> Iterator[NatsServer]:
    """Run one while the block runs."""
    server = NatsServer(folder, configuration, scheme)
    try:
        server.start()
        yield server
    finally:
        server.kill()


def settings(url: str, prefix: str = "", **more: Any) -> NatsSettings:
    """Return settings for a cluster of its own, or for that of `prefix`."""
    return NatsSettings((url,), prefix=prefix or f"test-{next(_clusters)}", **more)


@asynccontextmanager
async def links(*urls: str, **more: Any) -> AsyncIterator[list[NatsLink]]:
    """Enter links `a`, `b`, ... of one cluster, each by its own way to NATS."""
    prefix = f"test-{next(_clusters)}"
    async with AsyncExitStack() as stack:
        yield [
            await stack.enter_async_context(NatsLink(settings(url, prefix), name, **more))
            for name, url in zip("abcdefgh", urls, strict=False)
        ]


@asynccontextmanager
async def dialled(near: NatsLink, far: NatsLink) -> AsyncIterator[Callable[[], Any]]:
    """Yield a function that returns both ends of a new stream from one gateway to another."""
    accepted: asyncio.Queue[NatsStream] = asyncio.Queue()
    over = asyncio.Event()

    async def accept(stream: NatsStream, _hello: Any) -> None:
        stream.accept()
        await accepted.put(stream)
        await over.wait()

    async def pair() -> tuple[NatsStream, NatsStream]:
        return await near.dial(far.gateway_id, {}), await accepted.get()

    await far.listen(accept)
    try:
        yield pair
    finally:
        over.set()
