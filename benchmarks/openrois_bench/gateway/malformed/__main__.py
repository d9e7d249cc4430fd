"""A hundred thousand wrong messages, and their effect on another client.

`python -m openrois_bench.gateway.malformed`.
"""

import argparse
import asyncio
import json
import sys
from collections.abc import Sequence
from typing import Any

import uvloop

from openrois_bench.clone import require_clone
from openrois_bench.errors import BenchFailed
from openrois_bench.gateway.deployment import Deployment, deployed
from openrois_bench.gateway.load import applications
from openrois_bench.gateway.malformed.bystander import Bystander
from openrois_bench.gateway.security import OPEN
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import MICROSECONDS, Percentiles


async def _beside(deployment: Deployment, rate: float, what: Any) -> tuple[Percentiles, Any]:
    """Let the bystander ask for as long as something takes; return its waits and what that gave."""
    over = asyncio.Event()
    async with applications(deployment.door, 1) as (application,), asyncio.TaskGroup() as tasks:
        bystander = Bystander(application, rate)
        tasks.create_task(bystander.run(over))
        try:
            found = await what
        finally:
            over.set()
    return Percentiles.of(bystander.waits, MICROSECONDS), found


async def _flooded(url: str, chosen: argparse.Namespace) -> dict[str, Any]:
    arguments = (url, str(chosen.count), str(chosen.rate), str(chosen.seed))
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "openrois_bench.gateway.malformed.flood", *arguments, stdout=asyncio.subprocess.PIPE
    )
    told, _ = await process.communicate()
    if process.returncode:
        raise BenchFailed("the flood failed")
    found: dict[str, Any] = json.loads(told.decode().splitlines()[-1])
    return found


async def _run(chosen: argparse.Namespace) -> int:
    before = load()
    async with deployed(OPEN) as deployment:
        quiet, _ = await _beside(deployment, chosen.asks, asyncio.sleep(chosen.quiet))
        cpu = deployment.gateway.cpu()
        flooded, found = await _beside(deployment, chosen.asks, _flooded(deployment.door.url, chosen))
        cpu = deployment.gateway.cpu() - cpu
        after, _ = await _beside(deployment, chosen.asks, asyncio.sleep(chosen.quiet))
    print(conditions(before))
    print(f"{found['sent']} wrong messages, seed {chosen.seed}; right errors by code: {found['by_code']}")
    print(f"wrong answers: {found['wrong'] or 'none'}; without an answer: {found['missing']}")
    print(f"gateway: {cpu:.1f} s of processor time during the flood")
    for name, waits in (("before", quiet), ("during the flood", flooded), ("after", after)):
        print(f"bystander, {name}: {waits.count} answers in order; p50 {waits.p50:.0f} us, p99 {waits.p99:.0f} us")
    right = not found["wrong"] and not found["missing"] and sum(found["by_code"].values()) == found["sent"]
    return 0 if right else 1


def main(arguments: Sequence[str]) -> int:
    """Run it; 0 if each message got its one right error and the bystander all its answers."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.gateway.malformed", description=__doc__)
    parser.add_argument("--count", type=int, default=100_000, help="messages (%(default)s)")
    parser.add_argument("--rate", type=float, default=2000.0, help="a second; 0: as fast as answered (%(default)s)")
    parser.add_argument("--asks", type=float, default=200.0, help="queries of the bystander a second (%(default)s)")
    parser.add_argument("--quiet", type=float, default=10.0, help="seconds without a flood, twice (%(default)s)")
    parser.add_argument("--seed", type=int, default=6)
    chosen = parser.parse_args(arguments)
    require_clone()
    try:
        return uvloop.run(_run(chosen))
    except* BenchFailed as failed:
        print(*failed.exceptions, sep="\n")
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
