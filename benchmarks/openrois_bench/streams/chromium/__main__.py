"""Pictures in Chromium behind bad networks, of OpenRoIS and of aiortc alone.

`python -m openrois_bench.streams.chromium --json FILE`. A talking head (1280x720, 30 frames a second, H.264) passes a
relay with 20 ms of delay each way, and what the case adds. OpenRoIS is measured whole, with gateway and avatar adapter;
aiortc alone is given the same pictures, and as much of the wire as the page needs. Both take turns. A freeze is a
picture that stays for longer than 200 ms.
"""

import argparse
import asyncio
import itertools
from contextlib import AbstractAsyncContextManager
from pathlib import Path
from typing import Any, NamedTuple

import uvloop
from openrois_streaming.codecs import H264
from openrois_streaming.testing import Impairments
from openrois_streaming.testing.chromium import find_chromium
from openrois_streaming.testing.path import Direction

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import Percentiles, medians
from openrois_bench.measuring.result import write_result
from openrois_bench.streams.chromium.relay import impaired
from openrois_bench.streams.latency.__main__ import Size, plain
from openrois_bench.streams.latency.bench import avatar, patience
from openrois_bench.viewing.adapter import COMPONENT_REF, SOUND_REF
from openrois_bench.viewing.browser import chromium_version, watch_in_chromium
from openrois_bench.viewing.observation import Order, Sightings

WAYS = ("openrois", "aiortc")
SIZE = Size(1280, 720, 30)
DELAY = 0.02
FREEZE = 200.0
"""Milliseconds."""
MEDIANS = (
    *("presented_fps", "decoded_fps", "p50", "p95", "worst"),
    *("freezes", "longest_freeze", "first_picture", "dropped", "lost", "load"),
)
"""What is written of each case: over its rounds."""


class Case(NamedTuple):
    """Impairments of the path at first, and from a third to two thirds of the time."""

    name: str
    first: dict[str, Any]
    then: dict[str, Any] | None = None
    sound: bool = False


CASES = (
    Case("20 ms alone", {}),
    Case("1 Mbit/s", {"rate": 1e6}),
    Case("1 Mbit/s, 5 % loss", {"rate": 1e6, "loss": 0.05}),
    Case("5 % loss", {"loss": 0.05}),
    Case("0.7 Mbit/s in the middle", {}, {"rate": 0.7e6}),
    Case("0.7 Mbit/s in the middle, with sound", {}, {"rate": 0.7e6}, sound=True),
)


def _engine(way: str) -> AbstractAsyncContextManager[str]:
    return plain(SIZE, "head") if way == "aiortc" else avatar(*SIZE, show="head")


async def _bend(down: Direction, case: Case, seconds: float) -> None:
    """Change the path while it is watched."""
    if case.then is None:
        return
    before = {name: getattr(down.impairments, name) for name in case.then}
    await asyncio.sleep(seconds / 3)
    down.change(**case.then)
    await asyncio.sleep(seconds / 3)
    down.change(**before)


async def run(chromium: str, way: str, case: Case, seconds: float) -> dict[str, Any]:
    """One viewer, once."""
    async with (
        _engine(way) as host,
        impaired(f"ws://{host}/", Impairments(delay=DELAY, **case.first), Impairments(delay=DELAY)) as (url, path),
        asyncio.TaskGroup() as tasks,
    ):
        order = Order(
            url=url,
            component_ref=COMPONENT_REF,
            codec=H264,
            seconds=seconds,
            runs=1,
            resumes=0,
            settling=2.0,
            sound_ref=SOUND_REF if case.sound else None,
        )
        bending = tasks.create_task(_bend(path.down, case, order.settling + seconds))
        seen = await watch_in_chromium(chromium, order, patience=patience(order))
        bending.cancel()
        return _summed(seen, seconds) | {"dropped": path.down.figures().dropped, "lost": path.down.figures().lost}


def _summed(seen: Sightings, seconds: float) -> dict[str, Any]:
    gaps = [after - before for before, after in itertools.pairwise(seen.visible)]
    delays = seen.milliseconds["presented"]
    delay = Percentiles.of(delays)
    changes = [
        (round(at / 1000, 1), width)
        for at, width, before in zip(seen.visible, seen.widths, (0, *seen.widths), strict=False)
        if width != before
    ]
    return {
        "presented_fps": round(len(seen.numbers) / seconds, 1),
        "decoded_fps": round(seen.counters["framesDecoded"] / seconds, 1),
        "p50": delay.p50,
        "p95": delay.p95,
        "worst": max(delays),
        "unreadable": seen.unreadable,
        "freezes": sum(gap > FREEZE for gap in gaps),
        "longest_freeze": round(max(gaps)),
        "widths": changes,
        "first_picture": round(seen.milliseconds["connect"][0]),
        "apart": [round(each) for each in seen.milliseconds.get("apart", ())],
        "counters": seen.counters,
    }


async def measure(chromium: str, rounds: int, seconds: float) -> list[dict[str, Any]]:
    """All runs."""
    found = []
    for number, case in itertools.product(range(rounds), CASES):
        for way in WAYS if number % 2 == 0 else reversed(WAYS):
            if way == "aiortc" and case.sound:
                continue
            result = await run(chromium, way, case, seconds)
            found.append({"round": number, "way": way, "case": case.name, "load": load()} | result)
            print(
                f"{case.name:37} {way:8} decoded {result['decoded_fps']:4.1f} fps, presented "
                f"{result['presented_fps']:4.1f} fps, p50 {result['p50']:5.0f} ms, p95 {result['p95']:5.0f} ms, "
                f"freezes {result['freezes']} ({result['longest_freeze']} ms), "
                f"PLI {result['counters'].get('pliCount', 0):.0f}, load {load():.1f}",
                flush=True,
            )
    return found


def main() -> None:
    """Measure, and write it down."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path, help="where the medians go")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=24.0, help="that are watched of each")
    parser.add_argument("--quick", action="store_true", help="one round of 9 s each, to see that all works")
    options = parser.parse_args()
    if options.quick:
        vars(options).update(rounds=1, seconds=9.0)
    chromium = find_chromium()
    if chromium is None:
        parser.error("Chromium is needed and not installed (Debian: apt install chromium)")
    before = load()
    runs = uvloop.run(measure(chromium, options.rounds, options.seconds))
    versions = {"Chromium": asyncio.run(chromium_version(chromium))}
    summary = medians(runs, by=("case", "way"), of=MEDIANS)
    write_result(options.json, "openrois_bench.streams.chromium", conditions(before, versions), summary=summary)


if __name__ == "__main__":
    main()
