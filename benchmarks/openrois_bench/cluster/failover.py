"""How soon a body can be commanded again when the gateway that owns it is killed.

    python -m openrois_bench.cluster.failover [--rounds N] [--json FILE]

NATS, PostgreSQL and three gateways, each a process of its own. An adapter and two applications, in this one, know all
gateways. Of the applications one is at the owner, one elsewhere; the odd rounds kill the owner while the first one
holds the body, the even ones while the second one does. A time is from the kill.
"""

import argparse
import asyncio
import signal
import sys
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import uvloop
from aiohttp import ClientError, ClientSession

from openrois.adapter import Component, command
from openrois.adapter.dialer import serve_parent
from openrois.adapter.running import hosted
from openrois.aio.tasks import TaskScope
from openrois.client import Client, ConnectionFailed, ConnectionLost, Reconnect
from openrois.client.dialling import websocket
from openrois.errors import RoISError
from openrois.transport.stream import MessageStream
from openrois_bench.cluster.postgres import postgres_server
from openrois_bench.cluster.stream import nats_server
from openrois_bench.errors import within
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import Percentiles
from openrois_bench.measuring.result import write_result
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import free_port

__all__ = ["Case", "measure", "printed", "summary"]

PATIENCE: Final = 60.0
CASES: Final = ("the application is at the owner", "the application is at another gateway")
REF: Final = "body/arm"


class Arm(Component, authority="OpenRoIS", function="actuation"):
    """Component to be commanded again."""

    @command
    async def turn(self) -> None:
        """Turn."""


@dataclass(slots=True)
class Case:
    """What was measured of one case: seconds after the kill, of each round.

    Attributes:
        attached: until another gateway had attached the adapter.
        operated: until a command of the application that holds the body had ended well.
    """

    attached: list[float] = field(default_factory=list)
    operated: list[float] = field(default_factory=list)


class Gateway:
    """A gateway that is killed and started again at the same address."""

    def __init__(self, gateway_id: str, nats: str, store: str) -> None:
        self._port = free_port()
        self.url = f"http://127.0.0.1:{self._port}/"
        options = ("--gateway-id", gateway_id, "--cluster", nats, "--store", store, "--cluster-name", "bench")
        self._words = ("-P", "-m", "openrois.cli", "gateway", "--port", str(self._port), *options)
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


class Adapter:
    """An adapter that knows all gateways, and at which it is."""

    def __init__(self) -> None:
        self.attached_at = 0.0
        self._changed = asyncio.Event()

    @asynccontextmanager
    async def serving(self, urls: Sequence[str]) -> AsyncIterator[None]:
        async with hosted("body", Arm("arm")) as host, TaskScope() as tasks:
            tasks.start(serve_parent(host, *(f"{each.replace('http', 'ws', 1)}adapter" for each in urls), attached=self._note))
            yield

    def _note(self, is_attached: bool) -> None:
        if is_attached:
            self.attached_at = time.perf_counter()
            self._changed.set()

    async def attached(self, since: float) -> float:
        """Return when it was attached after a moment."""
        async with within(PATIENCE, "the adapter"):
            while self.attached_at < since:
                self._changed.clear()
                await self._changed.wait()
        return self.attached_at


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


async def operated(client: Client) -> float:
    """Command the body until a command has ended well; return when that was."""
    while True:
        with suppress(RoISError, ConnectionLost, TimeoutError):
            await client.component(REF).command("turn")
            return time.perf_counter()
        await asyncio.sleep(0.005)


async def measure(rounds: int, progress: Callable[[str], None]) -> dict[str, Case]:
    """Kill the owner so many times.

    Raises:
        BenchFailed: something that takes part did not do what it should.
    """
    cases = {name: Case() for name in CASES}
    async with AsyncExitStack() as stack:
        nats, _ = await stack.enter_async_context(nats_server())
        store = await stack.enter_async_context(postgres_server())
        gateways = [Gateway(name, nats, store) for name in "abc"]
        for each in gateways:
            stack.push_async_callback(each.kill)
            await each.start()
        for number in range(rounds):
            name = CASES[number % 2]
            case = cases[name]
            owner, *others = gateways[number % 3 :] + gateways[: number % 3]
            async with Adapter().serving([owner.url]):
                pass
            await _one_round(owner, others, name == CASES[0], case)
            await owner.start()
            progress(f"round {number + 1} of {rounds}")
    return cases


async def _one_round(owner: Gateway, others: Sequence[Gateway], is_at_owner: bool, case: Case) -> None:
    urls = [owner.url, *(each.url for each in others)]
    adapter = Adapter()
    # The order in which an adapter dials is by chance.
    async with adapter.serving(urls):
        await adapter.attached(0.0)
        first = urls if is_at_owner else [*urls[1:], urls[0]]
        async with Client(dial=dialling(first), reconnect=Reconnect(first=0.1, limit=0.5)) as client:
            async with within(PATIENCE, "the arm"):
                while True:
                    with suppress(RoISError):
                        await client.bind(REF)
                        break
                    await asyncio.sleep(0.05)
            await operated(client)
            killed = time.perf_counter()
            await owner.kill()
            async with within(PATIENCE, "a command after the kill"):
                case.operated.append(await operated(client) - killed)
            case.attached.append(await adapter.attached(killed) - killed)
