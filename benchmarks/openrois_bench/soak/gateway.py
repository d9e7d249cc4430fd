"""`python -m openrois_bench.soak.gateway`: leftovers at a gateway of applications that come and go for an hour."""

import argparse
import asyncio
import json
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

import uvloop

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import slope
from openrois_bench.measuring.result import write_result
from openrois_bench.processes.child import Child, child
from openrois_bench.soak.findings import figures, is_clean, left_over, sampled
from openrois_bench.soak.robot import ENGINE
from openrois_bench.soak.visits import Visitors

_SETTLING: Final = 15.0
"""Seconds until nothing may be left of the last visit: the grace of leases is 10."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Gateway and adapter at one moment; memory in MiB."""

    at: float
    gateway: float
    adapter: float
    descriptors: int
    tasks: int
    load: float


async def _sample(gateway: Child, adapter: Child, metrics: str) -> Sample:
    tasks = int((await asyncio.to_thread(figures, metrics))["openrois_gateway_tasks"])
    sizes = round(gateway.memory(), 2), round(adapter.memory(), 2)
    return Sample(round(time.monotonic(), 1), *sizes, gateway.descriptors(), tasks, load())


async def _soak(chosen: argparse.Namespace) -> dict[str, Any]:
    metrics = f"http://127.0.0.1:{chosen.metrics}/metrics"
    options = ("gateway", "--port", "0", "--metrics", f"127.0.0.1:{chosen.metrics}")
    async with child("-m", "openrois.cli", *options) as gateway:
        url = gateway.said.rpartition(" ")[2]
        async with child("-m", "openrois_bench.soak.robot", url) as adapter:
            sample = partial(_sample, gateway, adapter, metrics)
            visitors, over = Visitors(url, chosen.visitors, chosen.seed), asyncio.Event()

            async def crowd(minutes: float) -> list[Sample]:
                over.clear()
                visiting = asyncio.ensure_future(visitors.run(over))
                samples = await sampled(sample, minutes * 60)
                over.set()
                await visiting
                return samples

            # What is made once (modules, caches, the records that are kept) is there before anything is counted.
            await crowd(chosen.warm_up)
            rest = (await sampled(sample, _SETTLING))[-1]
            visitors.visits.clear()
            busy = await crowd(chosen.minutes)
            end = (await sampled(sample, _SETTLING))[-1]
    return {
        "engine": ENGINE,
        "visits": dict(visitors.visits),
        "faults": visitors.faults,
        "gateway_mb_per_hour": round(slope([(each.at, each.gateway) for each in busy]) * 3600, 2),
        "adapter_mb_per_hour": round(slope([(each.at, each.adapter) for each in busy]) * 3600, 2),
        "gateway_at_rest_mb": [rest.gateway, end.gateway],
        "adapter_at_rest_mb": [rest.adapter, end.adapter],
        "left_over": left_over(rest, end, "descriptors", "tasks"),
        "load": [min(each.load for each in busy), max(each.load for each in busy)],
    }


def main(arguments: Sequence[str]) -> int:
    """Run it; 0 if nothing is left over and every visit went well. Whether memory grows is for a person to judge."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.soak.gateway", description=__doc__)
    parser.add_argument("--minutes", type=float, default=60.0, help="after the warm-up (%(default)s)")
    parser.add_argument("--warm-up", type=float, default=5.0, help="minutes (%(default)s)")
    parser.add_argument("--visitors", type=int, default=8, help="at a time (%(default)s)")
    parser.add_argument("--seed", type=int, default=6)
    parser.add_argument("--metrics", type=int, default=18770, help="port of the gateway's figures (%(default)s)")
    parser.add_argument("--json", type=Path, help="write the figures here")
    chosen = parser.parse_args(arguments)
    before = load()
    report = uvloop.run(_soak(chosen))
    print(json.dumps(report, indent=1))
    write_result(chosen.json, "openrois_bench.soak.gateway", conditions(before), **report)
    return 0 if is_clean(report["left_over"]) and not report["faults"] else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
