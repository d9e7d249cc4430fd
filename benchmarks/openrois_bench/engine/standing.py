"""Cost of an unwatched avatar: processor time of its adapter and of its game engine.

`python -m openrois_bench.engine.standing`, in the repository, after nothing else runs; `--other FOLDER` measures the
checkout in another folder in turn with this one. A gateway, an adapter and the engine run as they do for users; no
application is there.
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

from openrois_bench.clone import ROOT, packages_of
from openrois_bench.measuring.conditions import load
from openrois_bench.processes.child import cpu_of, descendants

_SETTLE: Final = 4.0
"""Seconds after the start that are not measured."""


@contextmanager
def _running(checkout: Path, *arguments: str) -> Iterator[int]:
    """Run a command of a checkout, with the libraries of this Python, once it has said its first line."""
    path = os.pathsep.join(map(str, packages_of(checkout)))
    with subprocess.Popen(
        [sys.executable, "-m", "openrois.cli", *arguments],
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    ) as child:
        try:
            assert child.stdout is not None
            if not child.stdout.readline():
                raise SystemExit(f"{checkout}: openrois {arguments[0]} did not start: run it by hand to see why")
            yield child.pid
        finally:
            child.terminate()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def measured(checkout: Path, seconds: float, options: Sequence[str]) -> dict[str, float]:
    """Return the cores that the adapter and its engine use without a viewer."""
    port = str(_free_port())
    with (
        _running(checkout, "gateway", "--port", port),
        _running(checkout, "avatar", "--gateway", f"ws://127.0.0.1:{port}/adapter", *options) as adapter,
    ):
        time.sleep(_SETTLE)
        groups = {"adapter": [adapter], "engine": descendants(adapter)}
        before, begun = {name: cpu_of(*group) for name, group in groups.items()}, time.monotonic()
        time.sleep(seconds)
        passed = time.monotonic() - begun
        return {name: (cpu_of(*group) - before[name]) / passed for name, group in groups.items()}


def main() -> None:
    """Measure in turn, and print a line for each checkout."""
    parser = argparse.ArgumentParser(
        prog="python -m openrois_bench.engine.standing", description=(__doc__ or "").split("\n")[0]
    )
    parser.add_argument("--other", type=Path, metavar="FOLDER", help="a checkout to compare with")
    parser.add_argument("--engine", default="auto", help="what renders it (%(default)s)")
    parser.add_argument("--rounds", type=int, default=3, help="(%(default)s)")
    parser.add_argument("--seconds", type=float, default=20.0, help="of each round (%(default)s)")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    chosen = parser.parse_args()
    checkouts = {"this": ROOT, **({} if chosen.other is None else {"other": chosen.other.resolve()})}
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
