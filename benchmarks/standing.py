"""What it costs that an avatar stands there, not watched: processor time of its adapter and of its game engine.

`python -m benchmarks.standing`, in the repository, after nothing else runs; `--other FOLDER` measures the checkout in
another folder in turn with this one. A gateway, an adapter and the engine run as they do for users; no application is
there.
"""

import argparse
import json
import os
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import psutil

from openrois.bench.conditions import load

HERE: Final = Path(__file__).parent.parent
_PACKAGES: Final = ("", "signaling", "streaming", "avatar_adapter", "web_demo")
_SETTLE: Final = 4.0
"""Seconds after the start that are not measured."""


@contextmanager
def _running(checkout: Path, *arguments: str) -> Iterator[psutil.Process]:
    """Run a command of a checkout, with the libraries of this Python, once it has said its first line."""
    path = os.pathsep.join(str(checkout / package) for package in _PACKAGES)
    with subprocess.Popen(
        [sys.executable, "-m", "openrois.cli", *arguments],
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    ) as child:
        try:
            assert child.stdout is not None
            if not child.stdout.readline():
                raise SystemExit(f"{checkout}: openrois {arguments[0]} did not start")
            yield psutil.Process(child.pid)
        finally:
            child.terminate()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _seconds(processes: Sequence[psutil.Process]) -> float:
    return sum((float(sum(process.cpu_times()[:2])) for process in processes), 0.0)


def measured(checkout: Path, seconds: float, options: Sequence[str]) -> dict[str, float]:
    """Cores that the adapter and its engine take while nobody looks."""
    port = str(_free_port())
    with (
        _running(checkout, "gateway", "--port", port),
        _running(checkout, "avatar", "--gateway", f"ws://127.0.0.1:{port}/adapter", *options) as adapter,
    ):
        time.sleep(_SETTLE)
        groups = {"adapter": [adapter], "engine": adapter.children(recursive=True)}
        before, begun = {name: _seconds(group) for name, group in groups.items()}, time.monotonic()
        time.sleep(seconds)
        passed = time.monotonic() - begun
        return {name: (_seconds(group) - before[name]) / passed for name, group in groups.items()}


def main() -> None:
    """Measure in turn, and print a line for each checkout."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.standing", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--other", type=Path, metavar="FOLDER", help="a checkout to compare with")
    parser.add_argument("--engine", default="auto", help="what renders it (%(default)s)")
    parser.add_argument("--rounds", type=int, default=3, help="(%(default)s)")
    parser.add_argument("--seconds", type=float, default=20.0, help="of each round (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    chosen = parser.parse_args()
    checkouts = {"this": HERE, **({} if chosen.other is None else {"other": chosen.other.resolve()})}
    runs: dict[str, list[dict[str, float]]] = {name: [] for name in checkouts}
    for _ in range(chosen.rounds):
        for name, checkout in checkouts.items():
            runs[name].append({**measured(checkout, chosen.seconds, ("--engine", chosen.engine)), "load": load()})
    for name, rounds in runs.items():
        adapter, engine = (statistics.median(each[part] for each in rounds) for part in ("adapter", "engine"))
        both = statistics.median(each["adapter"] + each["engine"] for each in rounds)
        print(f"{name:<6} adapter {adapter:.4f}  engine {engine:.4f}  together {both:.4f} of a core")
    if chosen.json is not None:
        chosen.json.write_text(json.dumps({"seconds": chosen.seconds, "runs": runs}, indent=1) + "\n")


if __name__ == "__main__":
    main()
