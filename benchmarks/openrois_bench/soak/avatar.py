"""Soak of gateway, avatar and viewers for half an hour: reports leftovers and growth.

`python -m openrois_bench.soak.avatar --minutes 30`.
"""

import argparse
import asyncio
import json
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import slope
from openrois_bench.measuring.result import write_result
from openrois_bench.processes.child import Child, child
from openrois_bench.soak.findings import INTERVAL, figures, is_clean, left_over, sampled

_SETTLING: Final = 40.0
"""Seconds from the last viewer until nothing may be left: one that was killed is gone after 4, its session after 30."""
_MEGABYTES: Final = 1.048576
"""Of a MiB."""


@dataclass(frozen=True, slots=True)
class Sample:
    """The adapter at one moment."""

    at: float
    """Seconds."""
    rss: float
    """Megabytes."""
    cpu: float
    """Seconds that were used so far."""
    descriptors: int
    threads: int
    tasks: int
    sessions: int
    load: float


@dataclass
class Visits:
    """Visits that the viewers reported, over all their lives."""

    good: int = 0
    failed: int = 0
    killed: int = 0


async def _sample(adapter: Child, metrics: str) -> Sample:
    told = await asyncio.to_thread(figures, metrics)
    return Sample(
        at=round(time.monotonic(), 1),
        rss=round(adapter.memory() * _MEGABYTES, 2),
        cpu=round(adapter.cpu(), 2),
        descriptors=adapter.descriptors(),
        threads=_threads(adapter),
        tasks=int(told["openrois_tasks"]),
        sessions=int(told["openrois_sessions"]),
        load=load(),
    )


def _threads(process: Child) -> int:
    return len(list(Path(f"/proc/{process.pid}/task").iterdir()))


def _viewers(url: str, count: int, seed: int) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "openrois_bench.soak.viewers", url, str(count), str(seed)],
        stdout=subprocess.PIPE,
        text=True,
    )


def _end_viewers(process: subprocess.Popen[str], visits: Visits) -> None:
    process.kill()
    told, _ = process.communicate()
    lines = told.splitlines()
    visits.good += lines.count("visit")
    visits.failed += sum(line.startswith("failed") for line in lines)
    visits.killed += 1


async def _soak(sample: Callable[[], Awaitable[Sample]], url: str, chosen: argparse.Namespace) -> dict[str, Any]:
    visits = Visits()

    async def crowd(seconds: float) -> list[Sample]:
        samples: list[Sample] = []
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > INTERVAL:
            viewers = _viewers(url, chosen.viewers, chosen.seed + 1000 * visits.killed)
            samples += await sampled(sample, min(left, chosen.kill_every))
            _end_viewers(viewers, visits)
        return samples

    # What is loaded once (codecs, modules, caches) is there before anything is counted.
    await crowd(chosen.warm_up * 60)
    rest_before = (await sampled(sample, _SETTLING))[-1]
    busy = await crowd(chosen.minutes * 60)
    rest_after = (await sampled(sample, _SETTLING))[-1]
    hours = (rest_after.at - rest_before.at) / 3600
    return {
        "viewers": chosen.viewers,
        "minutes": chosen.minutes,
        "visits": asdict(visits),
        "left_over": left_over(rest_before, rest_after, "descriptors", "threads", "tasks", "sessions"),
        "rss_slope_mb_per_hour": round(slope([(each.at, each.rss) for each in busy]) * 3600, 2),
        "rss_at_rest_mb": [rest_before.rss, rest_after.rss],
        "rss_at_rest_growth_mb_per_hour": round((rest_after.rss - rest_before.rss) / hours, 2),
        "cpu_seconds_per_second": round((busy[-1].cpu - busy[0].cpu) / (busy[-1].at - busy[0].at), 3),
        "load": [min(each.load for each in busy), max(each.load for each in busy)],
    }


async def _run(chosen: argparse.Namespace) -> dict[str, Any]:
    metrics = f"http://127.0.0.1:{chosen.port + 1}/metrics"
    gateway = ("openrois.cli", "gateway", "--port", str(chosen.port))
    avatar = ("openrois.cli", "avatar", "--engine", "synthetic", "--metrics", str(chosen.port + 1))
    dial = ("--gateway", f"ws://127.0.0.1:{chosen.port}/adapter")
    async with child("-m", *gateway), child("-m", *avatar, *dial) as adapter:
        return await _soak(partial(_sample, adapter, metrics), f"ws://127.0.0.1:{chosen.port}/", chosen)


def main(arguments: Sequence[str]) -> int:
    """Run it; 0 if nothing is left over, 1 otherwise. Whether memory grows is for a person to judge."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.soak.avatar", description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0, help="after the warm-up (%(default)s)")
    parser.add_argument("--warm-up", type=float, default=6.0, help="minutes (%(default)s)")
    parser.add_argument("--viewers", type=int, default=4, help="at a time (%(default)s)")
    parser.add_argument("--kill-every", type=float, default=45.0, help="seconds until all viewers vanish (%(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--port", type=int, default=18765, help="of the gateway; metrics are one above (%(default)s)")
    parser.add_argument("--json", type=Path, help="write the figures here")
    chosen = parser.parse_args(arguments)
    before = load()
    report = asyncio.run(_run(chosen))
    print(json.dumps(report, indent=1))
    write_result(chosen.json, "openrois_bench.soak.avatar", conditions(before), **report)
    return 0 if is_clean(report["left_over"]) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
