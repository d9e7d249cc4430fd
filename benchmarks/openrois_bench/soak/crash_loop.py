"""Leftovers at a gateway of an application that binds, works, and crashes or releases ten thousand times.

    python -m openrois_bench.soak.crash_loop [--cycles 10000] [--json FILE]

Each cycle is a connection of its own. By chance it says hello, subscribes, runs a command, asks for a resume token, and
releases; then it disconnects, closes, or is cut off without a word, with what it has bound. The exit status is 1 if
anything is left of them when the grace of leases is over.
"""

import argparse
import asyncio
import json
import random
import sys
import time
import urllib.request
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import uvloop
from prometheus_client.parser import text_string_to_metric_families

from openrois.client import Client
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import slope
from openrois_bench.measuring.result import write_result
from openrois_bench.processes.child import Child, child
from openrois_bench.soak.connection import Connection, connected
from openrois_bench.soak.findings import is_clean
from openrois_bench.soak.robot import ARMS, ENGINE

WARM_UP: Final = 500
"""Cycles before anything is counted: modules, caches, and the records that are kept."""

SAMPLES: Final = 25

PATIENCE: Final = 20.0
"""Seconds until nothing may be left of the last one: the grace of leases is 10."""

LEFT: Final = {
    "tasks": "openrois_gateway_tasks",
    "leases": "openrois_gateway_leases",
    "absent holders": "openrois_gateway_absent_holders",
    "unfinished commands": "openrois_gateway_unfinished_commands",
    "applications": "openrois_gateway_connections",
    "subscriptions": "openrois_gateway_subscriptions",
    "silent connections": "openrois_gateway_silent_connections",
}
"""Figures of which nothing may be left."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Gateway and adapter after so many cycles; memory in MiB."""

    cycles: int
    gateway: float
    adapter: float
    descriptors: int
    adapter_descriptors: int
    kept: Mapping[str, int]


async def _sampled(cycles: int, gateway: Child, adapter: Child, metrics: str) -> Sample:
    def scrape() -> dict[str, int]:
        with urllib.request.urlopen(metrics, timeout=10) as response:
            families = list(text_string_to_metric_families(response.read().decode()))
        found = [each for family in families for each in family.samples if each.labels.get("kind") != "adapter"]
        return {what: int(sum(each.value for each in found if each.name == name)) for what, name in LEFT.items()}

    return Sample(
        cycles,
        round(gateway.memory(), 2),
        round(adapter.memory(), 2),
        gateway.descriptors(),
        adapter.descriptors(),
        await asyncio.to_thread(scrape),
    )


class _Looping:
    """One application that comes again and again."""

    def __init__(self, url: str, number: int, seed: int, count: Counter[str]) -> None:
        self._url = url
        self._arm = f"{ENGINE}/arm{number}"
        self._dice = random.Random(seed + number)
        self._count = count

    async def cycle(self) -> None:
        """Come once and go, one way or another."""
        dice = self._dice
        async with connected(self._url) as connection:
            extended = dice.random() < 0.7
            if extended:
                await connection.ask("openrois.hello", version="1")
            await self._bind(connection)
            if dice.random() < 0.5:
                condition = f"component_ref = '{self._arm}'"
                await connection.ask("rois.event.subscribe", event_type="turned", condition=condition)
            if dice.random() < 0.5:
                unit = {"component_ref": self._arm, "command_type": "turn", "command_id": "c"}
                await connection.ask("rois.command.execute", command_unit_list=[unit])
            if extended and dice.random() < 0.1:
                await connection.ask("openrois.lease.token")
                # Its lease would be kept for the grace, and block the others meanwhile.
                await connection.ask("rois.command.release", component_ref=self._arm)
            way = dice.choice(("release", "disconnect", "close", "cut", "cut", "cut"))
            if way == "release":
                await connection.ask("rois.command.release", component_ref=self._arm)
            elif way == "disconnect":
                await connection.ask("rois.system.disconnect")
            elif way == "cut":
                connection.cut()
        self._count[way] += 1

    async def _bind(self, connection: Connection) -> None:
        async with asyncio.timeout(PATIENCE):
            # Until the gateway has seen that the one before is gone.
            while (await connection.ask("rois.command.bind", component_ref=self._arm))["return_code"] != "OK":
                pass


async def _measure(chosen: argparse.Namespace) -> dict[str, Any]:
    count, began = Counter[str](), time.monotonic()
    metrics = f"http://127.0.0.1:{chosen.metrics}/metrics"
    options = ("gateway", "--port", "0", "--metrics", f"127.0.0.1:{chosen.metrics}")
    async with child("-m", "openrois.cli", *options) as gateway:
        url = gateway.said.rpartition(" ")[2]
        async with child("-m", "openrois_bench.soak.robot", url) as adapter:
            loops = [_Looping(url, number, chosen.seed, count) for number in range(ARMS)]

            async def cycles(many: int) -> None:
                async def some(each: _Looping) -> None:
                    for _ in range(many // ARMS):
                        await each.cycle()

                await asyncio.gather(*(some(each) for each in loops))

            await _attached(url)
            await cycles(WARM_UP)
            await asyncio.sleep(PATIENCE)
            rest = await _sampled(0, gateway, adapter, metrics)
            count.clear()
            samples = []
            for number in range(SAMPLES):
                await cycles(chosen.cycles // SAMPLES)
                samples.append(await _sampled(chosen.cycles // SAMPLES * (number + 1), gateway, adapter, metrics))
            took = time.monotonic() - began
            await asyncio.sleep(PATIENCE)
            end = await _sampled(chosen.cycles, gateway, adapter, metrics)
    later = samples[SAMPLES // 2 :]
    return {
        "cycles": dict(count),
        "seconds": round(took),
        "memory_mb": {"gateway": [rest.gateway, end.gateway], "adapter": [rest.adapter, end.adapter]},
        "second_half_kb_per_1000_cycles": {
            "gateway": round(slope([(each.cycles, each.gateway) for each in later]) * 1000 * 1024, 1),
            "adapter": round(slope([(each.cycles, each.adapter) for each in later]) * 1000 * 1024, 1),
        },
        "left_over": {
            "descriptors": end.descriptors - rest.descriptors,
            "adapter descriptors": end.adapter_descriptors - rest.adapter_descriptors,
            **{what: end.kept[what] - rest.kept[what] for what in LEFT},
        },
        "held_at_rest": end.kept,
    }


async def _attached(url: str) -> None:
    """Wait until the arms are there."""
    async with Client(url) as client, asyncio.timeout(PATIENCE):
        while f"{ENGINE}/arm0" not in await client.search():  # noqa: ASYNC110 - it is asked until it is there
            await asyncio.sleep(0.05)


def main() -> int:
    """Run it; 0 if nothing is left over. Whether memory grows is for a person to judge."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.soak.crash_loop", description=__doc__)
    parser.add_argument("--cycles", type=int, default=10_000, help="after the warm-up (%(default)s)")
    parser.add_argument("--seed", type=int, default=12)
    parser.add_argument("--metrics", type=int, default=18772, help="port of the gateway's figures (%(default)s)")
    parser.add_argument("--json", type=Path, help="write the figures here")
    chosen = parser.parse_args()
    before = load()
    report = uvloop.run(_measure(chosen))
    print(json.dumps(report, indent=1))
    write_result(chosen.json, "openrois_bench.soak.crash_loop", conditions(before), **report)
    return 0 if is_clean(report["left_over"]) else 1


if __name__ == "__main__":
    sys.exit(main())
