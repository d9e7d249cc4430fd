"""`python -m benchmarks.soak --minutes 30`: gateway, avatar and viewers; says what is left over and what has grown."""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Final

import psutil

from benchmarks.soak.findings import figures, is_clean, left_over, tell
from benchmarks.soak.slope import slope

_INTERVAL: Final = 2.0
_SETTLING: Final = 40.0
"""Seconds from the last viewer until nothing may be left: one that was killed is gone after 4, its session after 30."""
_START: Final = 30.0
_MEGABYTE: Final = 1e6


@dataclass(frozen=True, slots=True)
class Sample:
    """The adapter at one moment."""

    at: float
    """Seconds since the beginning."""
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
    """What the viewers said, over all their lives."""

    good: int = 0
    failed: int = 0
    killed: int = 0


class Adapter:
    """The adapter under test, seen from outside."""

    def __init__(self, process: subprocess.Popen[str], metrics: str) -> None:
        self._process = psutil.Process(process.pid)
        self._metrics = metrics
        self._began = time.monotonic()

    def sample(self) -> Sample:
        """Measure it now."""
        told = figures(self._metrics)
        with self._process.oneshot():
            times = self._process.cpu_times()
            return Sample(
                at=round(time.monotonic() - self._began, 1),
                rss=round(self._process.memory_info().rss / _MEGABYTE, 2),
                cpu=round(times.user + times.system, 2),
                descriptors=self._process.num_fds(),
                threads=self._process.num_threads(),
                tasks=int(told["openrois_tasks"]),
                sessions=int(told["openrois_sessions"]),
                load=round(os.getloadavg()[0], 2),
            )


@contextmanager
def _program(*arguments: str, ready: str = "") -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen([sys.executable, "-m", *arguments], stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        if ready and not process.stdout.readline().startswith(ready):
            raise SystemExit(f"{arguments} did not start")
        yield process
    finally:
        process.terminate()
        process.wait(_START)


def _viewers(url: str, count: int, seed: int) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "benchmarks.soak.viewers", url, str(count), str(seed)], stdout=subprocess.PIPE, text=True
    )


def _end_viewers(process: subprocess.Popen[str], visits: Visits) -> None:
    process.kill()
    told, _ = process.communicate()
    lines = told.splitlines()
    visits.good += lines.count("visit")
    visits.failed += sum(line.startswith("failed") for line in lines)
    visits.killed += 1


def _sampled(adapter: Adapter, seconds: float) -> list[Sample]:
    samples = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        samples.append(adapter.sample())
        time.sleep(_INTERVAL)
    return samples


def _soak(adapter: Adapter, url: str, chosen: argparse.Namespace) -> dict[str, Any]:
    visits = Visits()

    def crowd(seconds: float) -> list[Sample]:
        samples: list[Sample] = []
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > _INTERVAL:
            viewers = _viewers(url, chosen.viewers, chosen.seed + 1000 * visits.killed)
            samples += _sampled(adapter, min(left, chosen.kill_every))
            _end_viewers(viewers, visits)
        return samples

    # What is loaded once (codecs, modules, caches) is there before anything is counted.
    warm_up = crowd(chosen.warm_up * 60)
    rest_before = _sampled(adapter, _SETTLING)[-1]
    busy = crowd(chosen.minutes * 60)
    rest_after = _sampled(adapter, _SETTLING)[-1]
    hours = (rest_after.at - rest_before.at) / 3600
    return {
        "command": ["python", "-m", "benchmarks.soak", *sys.argv[1:]],
        "versions": {name: version(name) for name in ("openrois", "aiortc", "av")} | {"python": sys.version.split()[0]},
        "viewers": chosen.viewers,
        "minutes": chosen.minutes,
        "visits": asdict(visits),
        "left_over": left_over(rest_before, rest_after, "descriptors", "threads", "tasks", "sessions"),
        "rss_slope_mb_per_hour": round(slope([(sample.at, sample.rss) for sample in busy]) * 3600, 2),
        "rss_at_rest_mb": [rest_before.rss, rest_after.rss],
        "rss_at_rest_growth_mb_per_hour": round((rest_after.rss - rest_before.rss) / hours, 2),
        "cpu_seconds_per_second": round((busy[-1].cpu - busy[0].cpu) / (busy[-1].at - busy[0].at), 3),
        "load": [min(sample.load for sample in busy), max(sample.load for sample in busy)],
        "samples": [asdict(sample) for sample in (*warm_up, rest_before, *busy, rest_after)],
    }


def main(arguments: Sequence[str]) -> int:
    """Run it; 0 if nothing is left over, 1 otherwise. Whether memory grows is for a person to judge."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.soak", description=__doc__)
    parser.add_argument("--minutes", type=float, default=30.0, help="after the warm-up (%(default)s)")
    parser.add_argument("--warm-up", type=float, default=6.0, help="minutes (%(default)s)")
    parser.add_argument("--viewers", type=int, default=4, help="at a time (%(default)s)")
    parser.add_argument("--kill-every", type=float, default=45.0, help="seconds until all viewers vanish (%(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--port", type=int, default=18765, help="of the gateway; metrics are one above (%(default)s)")
    parser.add_argument("--json", type=Path, help="write everything here")
    chosen = parser.parse_args(arguments)
    gateway = ("openrois.cli", "gateway", "--port", str(chosen.port))
    avatar = ("openrois.cli", "avatar", "--engine", "synthetic", "--metrics", str(chosen.port + 1))
    dial = ("--gateway", f"ws://127.0.0.1:{chosen.port}/adapter")
    with _program(*gateway, ready="listening"), _program(*avatar, *dial, ready="ready") as process:
        adapter = Adapter(process, f"http://127.0.0.1:{chosen.port + 1}/metrics")
        report = _soak(adapter, f"ws://127.0.0.1:{chosen.port}/", chosen)
    tell(report, chosen.json)
    return 0 if is_clean(report["left_over"]) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
