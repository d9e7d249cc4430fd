"""One viewer behind 1 Mbit/s beside three fast ones that get the same source; and the same path with aiortc alone.

`python -m openrois_bench.streams.slow_viewer`, in the repository.
"""

import argparse
import asyncio
import json
import os
import sys
from collections.abc import Sequence
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any, Final

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import medians
from openrois_bench.measuring.result import write_result
from openrois_bench.processes.partner import Partner, partner

SLOW: Final = {"rate": 1_000_000, "delay": 0.02}
BACK: Final = {"delay": 0.02}
FAST: Final = ("fast 1", "fast 2", "fast 3")
WITHIN: Final = 20.0
SENDER: Final = "openrois_bench.streams.fanout.sender"


async def join(
    sender: Partner, viewers: Partner, viewer: str, down: dict[str, Any] | None, *, sink: str, seed: int
) -> None:
    """Connect a viewer to a sender, over a bad network if `down` describes one."""
    sdp = await sender.ask("offer", {"viewer": viewer}, within=WITHIN)
    asked = {"viewer": viewer, "sdp": sdp, "down": down, "up": BACK, "seed": seed, "sink": sink}
    answer = await viewers.ask("respond", asked, within=WITHIN)
    await sender.ask("answer", {"viewer": viewer, "sdp": answer}, within=WITHIN)


async def case(
    sender: Partner,
    viewers: Partner,
    fast: Sequence[str],
    down: dict[str, Any] | None,
    *,
    warm: float,
    seconds: float,
    sink: str,
    seed: int,
) -> dict[str, Any]:
    """Measure once: the fast viewers are there first, then the slow one comes; `warm` seconds later it is counted."""
    names = [*fast]
    for name in fast:
        await join(sender, viewers, name, None, sink=sink, seed=seed)
    if fast:
        await asyncio.sleep(warm)
    if down is not None:
        await join(sender, viewers, "slow", down, sink=sink, seed=seed)
        names.append("slow")
        await asyncio.sleep(warm)
    await viewers.ask("restart", {}, within=WITHIN)
    before = await sender.ask("read", {}, within=WITHIN)
    await asyncio.sleep(seconds)
    seen = await viewers.ask("read", {}, within=WITHIN)
    after = await sender.ask("read", {}, within=WITHIN)
    for name in names:
        await sender.ask("leave", {"viewer": name}, within=WITHIN)
        await viewers.ask("leave", {"viewer": name}, within=WITHIN)
    return {
        "load": os.getloadavg()[0],
        "sender_cpu": (after["cpu"] - before["cpu"]) / seconds,
        "repairs_per_second": (after["repairs"] - before["repairs"]) / seconds,
        "seen": seen,
    }


def rows_of(run: dict[str, Any]) -> list[dict[str, Any]]:
    """Return a row for each viewer of a run; a viewer that saw nothing waited all the time."""
    rows = []
    for viewer, seen in run["seen"].items():
        delay = seen["delay"] or dict.fromkeys(("p50", "p95"), seen["seconds"])
        times = {f"{name}_ms": 1000 * delay[name] for name in ("p50", "p95")}
        figures = {name: run[name] for name in ("sender_cpu", "repairs_per_second", "load")}
        viewers = "slow" if viewer == "slow" else "fast"
        rows.append(
            {"loss": run["loss"], "way": run["way"], "viewers": viewers, "fps": seen["fps"], **times, **figures}
        )
    return rows


def summary(runs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The medians of all rounds and viewers, by loss, way and kind of viewer."""
    rows = [row for run in runs for row in rows_of(run)]
    figures = ("fps", "p50_ms", "p95_ms", "sender_cpu", "repairs_per_second", "load")
    return medians(rows, by=("loss", "way", "viewers"), of=figures)


async def measure(chosen: argparse.Namespace) -> list[dict[str, Any]]:
    """All rounds, each with every way in turn."""
    results = []
    async with AsyncExitStack() as stack:
        ours = await stack.enter_async_context(partner(SENDER, "openrois", chosen.codec, "free"))
        plain = await stack.enter_async_context(partner(SENDER, "aiortc", chosen.plain_codec, "free"))
        viewers = await stack.enter_async_context(partner("openrois_bench.streams.slow_viewer.viewers"))
        for number in range(chosen.rounds):
            for loss in chosen.loss:
                down = {**SLOW, "loss": loss}
                for way, sender, fast, path in (
                    ("openrois", ours, FAST, down),
                    ("aiortc", plain, (), down),
                    ("fast alone", ours, FAST, None),
                ):
                    times = {"warm": chosen.warm, "seconds": chosen.seconds}
                    got = await case(sender, viewers, fast, path, **times, sink=chosen.sink, seed=number)
                    results.append({"round": number, "loss": loss, "way": way, **got})
                    print(f"round {number}, loss {loss:.0%}, {way}: load {got['load']:.1f}", file=sys.stderr)
    return results


def main() -> None:
    """Measure, and print and write what was found."""
    parser = argparse.ArgumentParser(prog="openrois_bench.streams.slow_viewer")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=20, help="that are counted in each case (%(default)s)")
    parser.add_argument("--warm", type=float, default=3, help="seconds from joining to counting (%(default)s)")
    parser.add_argument("--loss", type=float, nargs="*", default=[0.0, 0.05])
    parser.add_argument("--codec", default="video/H264", help="of OpenRoIS (%(default)s)")
    parser.add_argument("--plain-codec", default="video/VP8", help="of aiortc alone (%(default)s)")
    parser.add_argument("--sink", choices=("aiortc", "own"), default="aiortc", help="what all view with (%(default)s)")
    parser.add_argument("--json", type=Path, help="where the results go")
    chosen = parser.parse_args()
    load_before = load()
    results = asyncio.run(measure(chosen))
    rows = summary(results)
    for each in rows:
        print(json.dumps(each))
    write_result(chosen.json, "openrois_bench.streams.slow_viewer", conditions(load_before), summary=rows)


if __name__ == "__main__":
    main()
