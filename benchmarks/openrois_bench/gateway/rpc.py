"""`openrois bench rpc`: cost of a query through the gateway, beside the machine and the bare library."""

import asyncio
import time
from collections.abc import Awaitable, Callable, Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import Final, Literal

from websockets.asyncio.client import connect

from openrois_bench.errors import within
from openrois_bench.gateway.deployment import Deployment, deployed, request
from openrois_bench.gateway.gauge import COMPONENT
from openrois_bench.gateway.load import Application, Door, applications
from openrois_bench.gateway.security import OPEN, Security
from openrois_bench.measuring.conditions import Conditions, conditions, load
from openrois_bench.measuring.figures import MICROSECONDS, Figures, Percentiles, Throughput, median
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import child, own_cpu

__all__ = ["RpcReport", "RpcSettings", "run_rpc"]

PATIENCE: Final = 10.0
"""Seconds that answers may take that are still under way."""

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class RpcSettings:
    """Settings of the measurement.

    Attributes:
        rounds: how often everything is measured, one after the other.
        seconds: of each measurement with many requests at a time.
        requests: of each measurement with one request at a time.
        clients: connections that ask at a time.
        depth: requests of each that are unanswered at a time.
        rate: requests a second of the measurement at a fixed rate.
        security: how the gateway is protected; of the echoes only that of TCP is never encrypted.
    """

    rounds: int = 5
    seconds: float = 2.0
    requests: int = 1000
    clients: int = 8
    depth: int = 16
    rate: int = 500
    security: Security = OPEN


class RpcReport(Figures):
    """Results, as medians of the rounds; times in microseconds."""

    bench: Literal["rpc"] = "rpc"
    conditions: Conditions
    rounds: int
    clients: int
    depth: int
    rate: int
    security: str
    tcp: Percentiles
    echo: Percentiles
    echo_uvloop: Percentiles
    query: Percentiles
    pipelined: Throughput
    open_loop: Percentiles
    open_loop_echo: Percentiles
    hop: float
    ratio: float
    ratio_uvloop: float

    def __str__(self) -> str:
        waits = [
            ("raw TCP echo", self.tcp),
            ("websockets echo", self.echo),
            ("websockets echo, uvloop", self.echo_uvloop),
            ("query through the gateway", self.query),
        ]
        at_rate = [
            ("websockets echo, uvloop", self.open_loop_echo),
            ("query through the gateway", self.open_loop),
        ]
        many = self.pipelined
        return "\n".join(
            (
                f"{self.conditions}\n{self.security}; medians of {self.rounds} rounds",
                "",
                _table("one at a time", waits),
                "",
                _table(f"{self.rate} a second, whatever happens", at_rate),
                "",
                f"the hop, p50 of the query less that of the echo at {self.rate} a second: {self.hop:.0f} us",
                f"query / echo, p50, median of the rounds: {self.ratio:.2f} (uvloop's echo: {self.ratio_uvloop:.2f})",
                f"pipelined, {self.clients} clients x {self.depth}: {many.per_second:.0f} queries a second; "
                f"CPU of each: gateway {many.gateway_us:.0f} us, "
                f"adapter {many.adapter_us:.0f} us, load {many.load_us:.0f} us",
            )
        )


@dataclass(frozen=True, slots=True)
class _Round:
    tcp: Percentiles
    echo: Percentiles
    echo_uvloop: Percentiles
    query: Percentiles
    pipelined: Throughput
    open_loop: Percentiles
    open_loop_echo: Percentiles


def _table(title: str, waits: Sequence[tuple[str, Percentiles]]) -> str:
    return table(
        (title, "p50 us", "p95 us", "p99 us"),
        [(name, f"{w.p50:.0f}", f"{w.p95:.0f}", f"{w.p99:.0f}") for name, w in waits],
    )


def _query(number: int) -> bytes:
    return request(number, "rois.query.query", query_type="level", condition=f"component_ref = '{COMPONENT}'")


async def run_rpc(settings: RpcSettings, progress: Progress) -> RpcReport:
    """Measure and return the report.

    Raises:
        BenchFailed: something that is measured did not do what it should.
    """
    before = load()
    async with AsyncExitStack() as stack:
        deployment = await stack.enter_async_context(deployed(settings.security))
        shown = ("--certificate", *deployment.certificate) if deployment.certificate else ()
        floors = [
            await stack.enter_async_context(child("-P", "-m", "openrois_bench.gateway.echo", *loop, *shown))
            for loop in ((), ("--uvloop",))
        ]
        ports = [tuple(int(port) for port in floor.said.split()) for floor in floors]
        rounds = []
        for number in range(settings.rounds):
            rounds.append(await _round(settings, deployment, ports))
            progress(f"round {number + 1} of {settings.rounds}: {rounds[-1].pipelined.per_second:.0f} queries a second")
    return _report(settings, conditions(before), rounds)


async def _round(settings: RpcSettings, deployment: Deployment, ports: Sequence[tuple[int, ...]]) -> _Round:
    (tcp, *echo_port), (_, *uvloop_port) = ports
    scheme = "https" if deployment.certificate else "http"
    echo, echo_uvloop = (
        Door(f"{scheme}://127.0.0.1:{port}", deployment.door.context) for (port,) in (echo_port, uvloop_port)
    )
    return _Round(
        tcp=await _tcp(tcp, settings.requests),
        echo=await _sequential(settings.requests, echo),
        echo_uvloop=await _sequential(settings.requests, echo_uvloop),
        query=await _sequential(settings.requests, deployment.door),
        pipelined=await _pipelined(settings, deployment),
        open_loop=await _open_loop(settings, deployment.door),
        open_loop_echo=await _open_loop(settings, echo_uvloop),
    )


async def _timed(ask: Callable[[int], Awaitable[object]], count: int) -> Percentiles:
    """Ask one at a time; the first tenth warms up."""
    waits: list[float] = []
    for number in range(count + count // 10):
        began = time.perf_counter()
        await ask(number)
        waits.append(time.perf_counter() - began)
    return Percentiles.of(waits[count // 10 :], MICROSECONDS)


async def _tcp(port: int, count: int) -> Percentiles:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:

        async def ask(number: int) -> None:
            text = _query(number)
            writer.write(text)
            await reader.readexactly(len(text))

        return await _timed(ask, count)
    finally:
        writer.close()


async def _sequential(count: int, door: Door) -> Percentiles:
    async with connect(compression=None, proxy=None, **door.websocket()) as connection:

        async def ask(number: int) -> None:
            await connection.send(_query(number).decode())
            answer = f'"id":{number}'
            while answer not in (await connection.recv(decode=True)).replace(" ", ""):
                pass

        return await _timed(ask, count)


async def _pipelined(settings: RpcSettings, deployment: Deployment) -> Throughput:
    """Keep `depth` requests of each client unanswered: each answer makes room for the next request."""
    answered, asked_for = 0, settings.clients * settings.depth
    running, complete = True, asyncio.Event()

    def asking(application: Application) -> Callable[[bytes], None]:
        number = settings.depth

        def on_answer(_message: bytes) -> None:
            nonlocal answered, asked_for, number
            answered += 1
            if running:
                number += 1
                asked_for += 1
                application.send(_query(number))
            elif answered == asked_for:
                complete.set()

        return on_answer

    processes = (deployment.gateway, deployment.adapter)
    async with applications(deployment.door, settings.clients) as asked:
        for application in asked:
            application.on_message = asking(application)
            for number in range(settings.depth):
                application.send(_query(number))
        await asyncio.sleep(settings.seconds / 5)
        began, before, own, first = time.perf_counter(), [p.cpu() for p in processes], own_cpu(), answered
        await asyncio.sleep(settings.seconds)
        took, after, own_after, last = time.perf_counter() - began, [p.cpu() for p in processes], own_cpu(), answered
        running = False
        async with within(PATIENCE, "the last answers"):
            await complete.wait()
    count = max(last - first, 1)
    gateway, adapter = (b - a for a, b in zip(before, after, strict=True))
    return Throughput.of(count, took, gateway=gateway, adapter=adapter, load=own_after - own)


async def _open_loop(settings: RpcSettings, door: Door) -> Percentiles:
    """Ask at a fixed rate, however long answers take.

    No question waits for an answer. Each wait counts from when its question was sent: the timer of this process is late
    by up to a millisecond.
    """
    sent: list[float] = []
    waits: list[float] = []
    count, complete = int(settings.rate * settings.seconds), asyncio.Event()

    def on_answer(message: bytes) -> None:
        at = message.index(b'"id":') + 5
        number = int(message[at : message.index(b",", at)])
        waits.append(time.perf_counter() - sent[number])
        if len(waits) == count:
            complete.set()

    async with applications(door, settings.clients) as asked:
        for application in asked:
            application.on_message = on_answer
        began = time.perf_counter()
        for number in range(count):
            if (early := began + number / settings.rate - time.perf_counter()) > 0:
                await asyncio.sleep(early)
            sent.append(time.perf_counter())
            asked[number % len(asked)].send(_query(number))
        async with within(PATIENCE, "the last answers"):
            await complete.wait()
    return Percentiles.of(waits, MICROSECONDS)


def _report(settings: RpcSettings, found: Conditions, rounds: Sequence[_Round]) -> RpcReport:
    return RpcReport(
        conditions=found,
        rounds=settings.rounds,
        clients=settings.clients,
        depth=settings.depth,
        rate=settings.rate,
        security=str(settings.security),
        tcp=Percentiles.median([each.tcp for each in rounds]),
        echo=Percentiles.median([each.echo for each in rounds]),
        echo_uvloop=Percentiles.median([each.echo_uvloop for each in rounds]),
        query=Percentiles.median([each.query for each in rounds]),
        open_loop=Percentiles.median([each.open_loop for each in rounds]),
        open_loop_echo=Percentiles.median([each.open_loop_echo for each in rounds]),
        hop=median([each.open_loop.p50 - each.open_loop_echo.p50 for each in rounds]),
        pipelined=Throughput.median([each.pipelined for each in rounds]),
        ratio=median([each.query.p50 / each.echo.p50 for each in rounds]),
        ratio_uvloop=median([each.query.p50 / each.echo_uvloop.p50 for each in rounds]),
    )
