"""Cost of a further viewer, here and elsewhere: `python -m openrois_bench.streams.peers --json FILE`.

All send the same 2.5 Mbit/s of H.264, 30 frames a second, from one network namespace to viewers in another, with the
same SRTP profile: this package, aiortc with tracks of encoded frames, Janus (its streaming plugin) and pion (a
forwarder of ours); `plain` is aiortc with an encoder for each viewer, for as many viewers as a machine can carry.
Counted is the CPU time of the process that sends, kernel included; on one machine that holds the work of receiving.
Janus and pion are sent RTP by another process, which is not counted; only `plain` encodes. The
marginal cost is the difference between N viewers and 1, divided by N - 1. All of them take turns.

Needs Linux, root, and the programs that `setup.sh` installs; missing ones are left out.
"""

import argparse
import itertools
import json
import shutil
import statistics
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import medians
from openrois_bench.measuring.result import write_result
from openrois_bench.streams.peers.network import inside, network
from openrois_bench.streams.peers.sender import FORWARDER, KINDS

_PLAIN_MOST = 2
_PATIENCE = 120.0
_QUICK = {"viewers": [8], "seconds": 3.0, "repeats": 1}


def main() -> None:
    """Measure, and say what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="where the medians go")
    parser.add_argument("--viewers", type=int, nargs="+", default=[16, 32], metavar="N")
    parser.add_argument("--seconds", type=float, default=8.0, help="of each run")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", nargs="+", choices=sorted(KINDS), default=list(KINDS))
    parser.add_argument("--quick", action="store_true", help="one short round, to see that all works")
    options = parser.parse_args()
    if options.quick:
        vars(options).update(_QUICK)
    before = load()
    runs = list(_runs([kind for kind in options.only if _is_there(kind)], options))
    marginal = {kind: _marginal(runs, kind) for kind in dict.fromkeys(run["kind"] for run in runs)}
    for kind, thousandths in marginal.items():
        ratio = f", ours is {marginal['ours'] / thousandths:.2f} of it" if "ours" in marginal and kind != "ours" else ""
        print(f"a further viewer of {kind}: {thousandths:.2f} thousandths of a core{ratio}")
    figures = ("cpu", "packets_per_viewer", "kbits_per_viewer", "load")
    write_result(
        options.json,
        "openrois_bench.streams.peers",
        conditions(before, _versions()),
        summary=medians(runs, by=("kind", "viewers"), of=figures),
        marginal=marginal,
    )


def _runs(kinds: Sequence[str], options: argparse.Namespace) -> Iterator[dict[str, Any]]:
    with network() as made:
        for _, viewers, kind in itertools.product(range(options.repeats), [1, *options.viewers], kinds):
            if kind == "plain" and viewers > 1:
                if viewers != options.viewers[0]:
                    continue
                viewers = _PLAIN_MOST
            arguments = (kind, str(viewers), str(options.seconds), made.viewers)
            command = inside(made.sender, sys.executable, "-m", "openrois_bench.streams.peers.sender", *arguments)
            done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, timeout=_PATIENCE)
            run = json.loads(done.stdout.splitlines()[-1])
            print(
                f"{kind:7} N={viewers:<3} {run['cpu']:.3f} cores, {run['packets_per_viewer']:.0f} packets/s and "
                f"{run['kbits_per_viewer']:.0f} kbit/s a viewer, load {run['load']:.1f}",
                flush=True,
            )
            yield run


def _marginal(runs: Sequence[dict[str, Any]], kind: str) -> float:
    """Thousandths of a core for one more viewer, between 1 and the most."""
    counts: set[int] = {run["viewers"] for run in runs if run["kind"] == kind}
    most, least = max(counts), min(counts)
    cpu: dict[int, float] = {
        count: statistics.median(run["cpu"] for run in runs if (run["kind"], run["viewers"]) == (kind, count))
        for count in (most, least)
    }
    return (cpu[most] - cpu[least]) / (most - least) * 1000


def _is_there(kind: str) -> bool:
    there = {"janus": shutil.which("janus") is not None, "pion": FORWARDER.is_file()}.get(kind, True)
    if not there:
        print(f"{kind} is not installed, and left out")
    return there


def _versions() -> dict[str, str]:
    """Of what Debian installed."""
    names = {"Janus": "janus", "pion": "golang-github-pion-webrtc.v3-dev", "Go": "golang-go"}
    if shutil.which("dpkg-query") is None:
        return {}
    found = {}
    for name, package in names.items():
        asked = subprocess.run(
            ["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True, check=False
        )
        if asked.returncode == 0:
            found[name] = asked.stdout
    return found


if __name__ == "__main__":
    main()
