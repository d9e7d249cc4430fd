"""How soon a body can be commanded again when the gateway that owns it is killed.

    python -m openrois_bench.cluster.failover [--rounds N] [--json FILE]

NATS, PostgreSQL and three gateways, each a process of its own. An adapter and an application, in this one, know all
gateways. The application holds the body, at its owner and at another gateway in turn, when the owner is killed.
"""

import argparse
import asyncio
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from openrois.adapter import Component, command
from openrois.adapter.dialer import serve_parent
from openrois.adapter.running import hosted
from openrois.aio.tasks import TaskScope
from openrois.client import Client, ConnectionLost, Reconnect
from openrois.errors import RoISError
from openrois.transport.address import adapter_url
from openrois_bench.cluster.gateways import PATIENCE, Cluster, Gateway, dialling, three_gateways
from openrois_bench.cluster.reporting import measure_and_report
from openrois_bench.errors import within
from openrois_bench.measuring.figures import MILLISECONDS, Percentiles
from openrois_bench.measuring.table import table

__all__ = ["CASES", "Case", "measure", "printed", "summary"]

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


class Adapter:
    """An adapter that knows all gateways."""

    def __init__(self) -> None:
        self._attached_at = 0.0
        self._changed = asyncio.Event()

    @asynccontextmanager
    async def serving(self, urls: Sequence[str]) -> AsyncIterator[None]:
        async with hosted("body", Arm("arm")) as host, TaskScope() as tasks:
            tasks.start(serve_parent(host, *map(adapter_url, urls), attached=self._note))
            yield

    def _note(self, is_attached: bool) -> None:
        if is_attached:
            self._attached_at = time.perf_counter()
            self._changed.set()

    async def attached(self, since: float) -> float:
        """Return when it was attached after a moment."""
        async with within(PATIENCE, "the adapter"):
            while self._attached_at < since:
                self._changed.clear()
                await self._changed.wait()
        return self._attached_at


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
    async with three_gateways() as running:
        for number in range(rounds):
            name = CASES[number % 2]
            killed = await _one_round(running, cases[name], is_at_owner=name == CASES[0])
            await killed.start()
            progress(f"round {number + 1} of {rounds}")
    return cases


async def _one_round(running: Cluster, case: Case, *, is_at_owner: bool) -> Gateway:
    """Kill the gateway that owns the body; return it."""
    adapter, began = Adapter(), time.perf_counter()
    async with adapter.serving(running.urls):
        await adapter.attached(began)
        owner = await running.owner_of("body")
        others = [url for url in running.urls if url != owner.url]
        urls = [owner.url, *others] if is_at_owner else [*others, owner.url]
        async with Client(dial=dialling(urls), reconnect=Reconnect(first=0.1, limit=0.5)) as client:
            async with within(PATIENCE, "the body, as the application sees it"):
                while not await _binds(client):  # noqa: ASYNC110 - a gateway learns of it from the one that has it
                    await asyncio.sleep(0.05)
                await operated(client)
            killed = time.perf_counter()
            await owner.kill()
            async with within(PATIENCE, "a command after the kill"):
                case.operated.append(await operated(client) - killed)
            case.attached.append(await adapter.attached(killed) - killed)
    return owner


async def _binds(client: Client) -> bool:
    try:
        await client.bind(REF)
    except RoISError:
        return False
    return True


def summary(cases: Mapping[str, Case]) -> dict[str, Any]:
    """Return the figures, times in milliseconds."""
    return {
        name: {
            "attached": Percentiles.of(case.attached, MILLISECONDS).model_dump(),
            "operated": Percentiles.of(case.operated, MILLISECONDS).model_dump(),
            "longest": round(max(case.operated) * MILLISECONDS),
        }
        for name, case in cases.items()
    }


def printed(figures: Mapping[str, Any]) -> str:
    """Return the figures as a table."""
    rows = [
        (
            name,
            f"{told['operated']['count']}",
            f"{told['attached']['p50']:.0f}",
            f"{told['operated']['p50']:.0f}",
            f"{told['longest']}",
        )
        for name, told in figures.items()
    ]
    head = ("the owner is killed", "times", "adapter elsewhere, median ms", "operated again, median ms", "longest ms")
    return table(head, rows)


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.cluster.failover", description=__doc__)
    parser.add_argument("--rounds", type=int, default=20, help="of both cases together (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE")
    chosen = parser.parse_args()

    async def measured(progress: Callable[[str], None]) -> dict[str, Any]:
        return summary(await measure(chosen.rounds, progress))

    measure_and_report("openrois_bench.cluster.failover", measured, printed, chosen.json)


if __name__ == "__main__":
    main()
