"""Gateways of a cluster as processes, with NATS and PostgreSQL, for benchmarks that kill them."""

import asyncio
import signal
import socket
import sys
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AsyncExitStack, ExitStack, asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any, Final

import asyncpg
from aiohttp import ClientError, ClientSession

from openrois.client import ConnectionFailed
from openrois.client.dialling import websocket
from openrois.transport.stream import MessageStream
from openrois_bench.cluster.postgres import postgres_server
from openrois_bench.cluster.stream import nats_server
from openrois_bench.errors import within

__all__ = ["PATIENCE", "Cluster", "Gateway", "dialling", "three_gateways"]

PATIENCE: Final = 60.0
"""Seconds for what has to come about on a busy machine."""


class Gateway:
    """A gateway that is killed and started again at the same address."""

    def __init__(self, gateway_id: str, port: int, nats: str, store: str) -> None:
        self.url = f"http://127.0.0.1:{port}/"
        options = ("--gateway-id", gateway_id, "--cluster", nats, "--store", store, "--cluster-name", "bench")
        self._words = ("-P", "-m", "openrois.cli", "gateway", "--port", str(port), *options)
        self._process: asyncio.subprocess.Process | None = None

    async def start(self) -> None:
        """Start it, and wait until it is ready."""
        quiet = asyncio.subprocess.DEVNULL
        self._process = await asyncio.create_subprocess_exec(sys.executable, *self._words, stdout=quiet, stderr=quiet)
        async with within(PATIENCE, f"the start of {self.url}"), ClientSession() as http:
            while True:
                with suppress(ClientError):
                    async with http.get(f"{self.url}readyz") as answer:
                        if answer.status == 200:
                            return
                await asyncio.sleep(0.05)

    async def kill(self) -> None:
        """Kill it."""
        if self._process is not None and self._process.returncode is None:
            self._process.send_signal(signal.SIGKILL)
            await self._process.wait()


@dataclass(frozen=True, slots=True)
class Cluster:
    """Gateways that share a store.

    Attributes:
        gateways: by their ids.
        store: the address of PostgreSQL.
    """

    gateways: Mapping[str, Gateway]
    store: str

    @property
    def urls(self) -> list[str]:
        """The addresses of all gateways."""
        return [each.url for each in self.gateways.values()]

    async def owner_of(self, engine_id: str) -> Gateway:
        """Wait until an engine has an owner, and return that."""
        asked = "SELECT gateway_id FROM openrois.claim WHERE engine_id = $1"
        connection = await asyncpg.connect(self.store)
        try:
            async with within(PATIENCE, f"the owner of {engine_id}"):
                while (found := await connection.fetchval(asked, engine_id)) is None:  # noqa: ASYNC110 - it is read
                    await asyncio.sleep(0.05)
                return self.gateways[found]
        finally:
            await connection.close()


@asynccontextmanager
async def three_gateways() -> AsyncIterator[Cluster]:
    """Run three gateways, with NATS and PostgreSQL, while the block runs.

    Raises:
        BenchFailed: one of them did not start.
    """
    async with AsyncExitStack() as stack:
        nats, _ = await stack.enter_async_context(nats_server())
        store = await stack.enter_async_context(postgres_server())
        ports = zip("abc", _free_ports(3), strict=True)
        running = Cluster({each: Gateway(each, port, nats, store) for each, port in ports}, store)
        for gateway in running.gateways.values():
            stack.push_async_callback(gateway.kill)
            await gateway.start()
        yield running


def dialling(urls: Sequence[str]) -> Callable[[], Any]:
    """Return what connects a client to the first of several gateways that is there."""

    @asynccontextmanager
    async def connect() -> AsyncIterator[MessageStream]:
        async with AsyncExitStack() as stack:
            for number, url in enumerate(urls):
                try:
                    stream = await stack.enter_async_context(websocket(url)())
                    break
                except ConnectionFailed:
                    if number + 1 == len(urls):
                        raise
            yield stream

    return connect


def _free_ports(count: int) -> list[int]:
    """Return so many ports of loopback that are free."""
    with ExitStack() as stack:
        probes = [stack.enter_context(socket.socket()) for _ in range(count)]
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [probe.getsockname()[1] for probe in probes]
