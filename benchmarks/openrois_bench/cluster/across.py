"""What it costs that a body is at another gateway: the same questions at its owner, and at another gateway.

    python -m openrois_bench.cluster.across [--rounds N] [--json FILE]

NATS, PostgreSQL, two gateways and an adapter, each a process of its own. Each round asks a query one at a time at the
gateway that has the adapter and at the other one, in turn.
"""

import argparse
import asyncio
import json
import time
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from openrois_bench.cluster.postgres import postgres_server
from openrois_bench.cluster.reporting import measure_and_report
from openrois_bench.cluster.stream import nats_server
from openrois_bench.errors import within
from openrois_bench.gateway.deployment import request
from openrois_bench.gateway.gauge import COMPONENT
from openrois_bench.gateway.load import Application, Door, applications
from openrois_bench.measuring.figures import MICROSECONDS, Percentiles, median
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import Child, child, cpu_of

__all__ = ["AcrossSettings", "measure"]

PATIENCE: Final = 30.0
CONDITION: Final = f"component_ref = '{COMPONENT}'"
WAYS: Final = ("at the owner", "at another gateway")


@dataclass(frozen=True, slots=True)
class AcrossSettings:
    """How much is measured.

    Attributes:
        rounds: of both ways.
        asked: queries of each round and way.
    """

    rounds: int = 10
    asked: int = 500


@dataclass(slots=True)
class Way:
    """What was measured of one way.

    Attributes:
        times: seconds of each query.
        medians: of them, in microseconds, of each round.
        cpu: microseconds of both gateways for a query, of each round.
    """

    times: list[float] = field(default_factory=list)
    medians: list[float] = field(default_factory=list)
    cpu: list[float] = field(default_factory=list)


@asynccontextmanager
async def _gateway(gateway_id: str, nats: str, store: str) -> AsyncIterator[Child]:
    options = ("--gateway-id", gateway_id, "--cluster", nats, "--store", store, "--cluster-name", "bench")
    async with child("-P", "-m", "openrois.cli", "gateway", "--port", "0", *options) as started:
        yield started


class _Asking:
    """An application that asks one thing at a time."""

    def __init__(self, application: Application) -> None:
        self._application = application
        self._number = 0
        self._answer: asyncio.Future[dict[str, Any]] | None = None
        application.on_message = self._handle

    def _handle(self, message: bytes) -> None:
        said = json.loads(message)
        if self._answer is not None and said.get("id") == self._number and not self._answer.done():
            self._answer.set_result(said)

    async def ask(self, method: str, **params: object) -> dict[str, Any]:
        self._number += 1
        self._answer = asyncio.get_running_loop().create_future()
        self._application.send(request(self._number, method, **params))
        return await self._answer

    async def until_found(self) -> None:
        async with within(PATIENCE, "the adapter, as an application sees it"):
            while True:
                if COMPONENT in str(await self.ask("rois.command.search", condition="")):
                    return
                await asyncio.sleep(0.05)

    async def timed(self, number: int) -> list[float]:
        times = []
        for _ in range(number + number // 10):
            began = time.perf_counter()
            await self.ask("rois.query.query", query_type="level", condition=CONDITION)
            times.append(time.perf_counter() - began)
        return times[number // 10 :]


async def measure(settings: AcrossSettings, progress: Callable[[str], None]) -> dict[str, Way]:
    """Measure both ways in turn.

    Raises:
        BenchFailed: something that takes part did not do what it should.
    """
    ways = {name: Way() for name in WAYS}
    async with AsyncExitStack() as stack:
        nats, _ = await stack.enter_async_context(nats_server())
        store = await stack.enter_async_context(postgres_server())
        owner = await stack.enter_async_context(_gateway("owner", nats, store))
        other = await stack.enter_async_context(_gateway("other", nats, store))
        urls = [each.said.rpartition(" ")[2] for each in (owner, other)]
        await stack.enter_async_context(child("-P", "-m", "openrois_bench.gateway.gauge", urls[0]))
        askers = []
        for url in urls:
            (application,) = await stack.enter_async_context(applications(Door(url), 1))
            askers.append(_Asking(application))
            await askers[-1].until_found()
        for number in range(settings.rounds):
            for name, asker in zip(WAYS, askers, strict=True):
                before = cpu_of(owner.pid, other.pid)
                times = await asker.timed(settings.asked)
                used = cpu_of(owner.pid, other.pid) - before
                ways[name].times += times
                ways[name].medians.append(Percentiles.of(times, MICROSECONDS).p50)
                ways[name].cpu.append(used / (settings.asked * 1.1) * MICROSECONDS)
            progress(f"round {number + 1} of {settings.rounds}")
    return ways


def summary(ways: Mapping[str, Way]) -> dict[str, Any]:
    """Return the figures, times in microseconds."""
    figures: dict[str, Any] = {
        name: {"query": Percentiles.of(way.times, MICROSECONDS).model_dump(), "cpu_us": round(median(way.cpu))}
        for name, way in ways.items()
    }
    owner, other = (ways[name].medians for name in WAYS)
    added = [(far - near) / near for near, far in zip(owner, other, strict=True)]
    return {**figures, "added": round(median(added), 2)}


def printed(figures: Mapping[str, Any]) -> str:
    """Return the figures as a table."""
    rows = [
        (name, *(f"{figures[name]['query'][each]:.0f}" for each in ("p50", "p99")), f"{figures[name]['cpu_us']}")
        for name in WAYS
    ]
    head = ("a query, there and back", "p50 us", "p99 us", "CPU of both gateways, us")
    return f"{table(head, rows)}\n\nadded at another gateway, in queries at the owner (p50): {figures['added']}"


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.cluster.across", description=__doc__)
    parser.add_argument("--rounds", type=int, default=AcrossSettings().rounds, help="of both ways (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE")
    chosen = parser.parse_args()

    async def measured(progress: Callable[[str], None]) -> dict[str, Any]:
        return summary(await measure(AcrossSettings(rounds=chosen.rounds), progress))

    measure_and_report("openrois_bench.cluster.across", measured, printed, chosen.json)


if __name__ == "__main__":
    main()
