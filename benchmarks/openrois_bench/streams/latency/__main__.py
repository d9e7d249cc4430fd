"""From capture to viewer, as OpenRoIS sends and as aiortc alone does.

`python -m openrois_bench.streams.latency --json FILE`. Colour bars in H.264 are played by two viewers after another, a
measuring sink and Chromium: each connects, plays, suspends and resumes. OpenRoIS is measured whole, with gateway and
avatar adapter; aiortc alone is given the same pictures, and as much of the wire as the viewers need. Both take turns.
Without Chromium there are figures of the sink.
"""

import argparse
import asyncio
import itertools
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, NamedTuple

from openrois_streaming.codecs import H264
from openrois_streaming.testing.chromium import find_chromium

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import Percentiles, medians
from openrois_bench.measuring.result import write_result
from openrois_bench.streams.latency.bench import avatar, patience, watch_in_sink
from openrois_bench.viewing.adapter import COMPONENT_REF, Show
from openrois_bench.viewing.browser import chromium_version, watch_in_chromium
from openrois_bench.viewing.observation import MEASURES, Order, Sightings, missed


class Size(NamedTuple):
    """Of pictures, and how many a second."""

    width: int
    height: int
    fps: int


SIZES = (Size(1280, 720, 30), Size(1280, 720, 60))
WAYS = ("openrois", "aiortc")


@asynccontextmanager
async def plain(size: Size, show: Show = "bars") -> AsyncIterator[str]:
    """Run aiortc alone; yields the `host:port` of its gateway."""
    command = (sys.executable, "-m", "openrois_bench.streams.latency.plain", *map(str, size), show)
    pipe = asyncio.subprocess.PIPE
    process = await asyncio.create_subprocess_exec(*command, stdin=pipe, stdout=pipe)
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        line = (await process.stdout.readline()).decode()
        yield line.strip().removeprefix("listening ws://").rstrip("/")
    finally:
        process.stdin.close()
        await process.wait()


async def _watched(way: str, size: Size, seconds: float, runs: int, chromium: str | None) -> dict[str, Sightings]:
    """Return the sightings of each viewer, by its name."""
    async with plain(size) if way == "aiortc" else avatar(*size) as host:
        order = Order(
            url=f"ws://{host}/",
            component_ref=COMPONENT_REF,
            codec=H264,
            seconds=seconds,
            runs=runs,
            resumes=runs,
            fps=size.fps,
        )
        seen = {"sink": await watch_in_sink(order)}
        if chromium is not None:
            seen["Chromium"] = await watch_in_chromium(chromium, order, patience=patience(order))
        return seen


async def measure(rounds: int, seconds: float, runs: int, chromium: str | None) -> list[dict[str, Any]]:
    """A row for each measure of each run."""
    found: list[dict[str, Any]] = []
    for number, size in itertools.product(range(rounds), SIZES):
        for way in WAYS if number % 2 == 0 else reversed(WAYS):
            for viewer, seen in (await _watched(way, size, seconds, runs, chromium)).items():
                rows = {name: Percentiles.of(seen.milliseconds[name]) for name in MEASURES if name in seen.milliseconds}
                run = {"height": size.height, "fps": size.fps, "viewer": viewer, "way": way, "load": load()}
                found += [{**run, "measure": name, "p50": row.p50, "p95": row.p95} for name, row in rows.items()]
                told = ", ".join(f"{name} {row.p50:.1f}" for name, row in rows.items())
                print(
                    f"{size.height}p{size.fps} {way:8} {viewer:8} {told} ms, {missed(seen.numbers)} pictures missed, "
                    f"load {load():.1f}",
                    flush=True,
                )
    return found


def summed(runs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The median over the rounds of each measure's median and p95, by size, viewer and way."""
    order = {name: place for place, name in enumerate(("sink", "Chromium", *MEASURES, *WAYS))}
    rows = medians(runs, by=("height", "fps", "viewer", "measure", "way"), of=("p50", "p95"))
    return sorted(
        rows, key=lambda row: (row["height"], row["fps"], *(order[row[name]] for name in ("viewer", "measure", "way")))
    )


def main() -> None:
    """Measure, and say what came of it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="where the medians go")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=6.0, help="that each viewer plays")
    parser.add_argument("--runs", type=int, default=7, help="of connecting and resuming")
    parser.add_argument("--quick", action="store_true", help="one short round, to see that all works")
    options = parser.parse_args()
    if options.quick:
        vars(options).update(rounds=1, seconds=2.0, runs=2)
    before, chromium = load(), find_chromium()
    runs = asyncio.run(measure(options.rounds, options.seconds, options.runs, chromium))
    rows = summed(runs)
    for row in rows:
        print(
            f"{row['height']}p{row['fps']} {row['viewer']:8} {MEASURES[row['measure']]:32} {row['way']:8} "
            f"median {row['p50']:6.1f} ms, p95 {row['p95']:6.1f} ms"
        )
    versions = {} if chromium is None else {"Chromium": asyncio.run(chromium_version(chromium))}
    write_result(options.json, "openrois_bench.streams.latency", conditions(before, versions), summary=rows)


if __name__ == "__main__":
    main()
