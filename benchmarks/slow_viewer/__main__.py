"""One viewer behind 1 Mbit/s beside three fast ones that get the same source; and the same path with aiortc alone.

`python -m benchmarks.slow_viewer`, in the repository.
"""

import argparse
import asyncio
import json
import os
import statistics
import sys
from collections.abc import Sequence
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any, Final

from openrois_avatar.bench.partner import Partner, partner

from openrois.bench.conditions import conditions, load

SLOW: Final = {"rate": 1_000_000, "delay": 0.02}
BACK: Final = {"delay": 0.02}
FAST: Final = ("fast 1", "fast 2", "fast 3")
WITHIN: Final = 20.0


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
    repairs = [sum(each["repairs"] for each in figures["renditions"]) for figures in (before, after)]
    return {
        "load": os.getloadavg()[0],
        "sender_cpu": (after["cpu"] - before["cpu"]) / seconds,
        "repairs_per_second": (repairs[1] - repairs[0]) / seconds,
        "seen": seen,
        "sender": {"before": before, "after": after},
    }


def summary(results: Sequence[dict[str, Any]], loss: float) -> dict[str, Any]:
    """The medians of all rounds at one rate of loss, and what is asked of them."""

    def median(way: str, viewers: Sequence[str], *path: str) -> float:
        values: list[float] = []
        for result in results:
            if result["way"] == way and result["loss"] == loss:
                for viewer in viewers:
                    value: Any = result["seen"][viewer]
                    for step in path:
                        # Who saw nothing waited all the time.
                        value = result["seen"][viewer]["seconds"] if value is None else value[step]
                    values.append(value)
        return statistics.median(values)

    ours = [each for each in results if each["way"] == "openrois" and each["loss"] == loss]
    slow, plain = median("openrois", ["slow"], "delay", "p50"), median("aiortc", ["slow"], "delay", "p50")
    return {
        "loss": loss,
        "slow_fps": median("openrois", ["slow"], "fps"),
        "slow_p50_ms": 1000 * slow,
        "slow_p95_ms": 1000 * median("openrois", ["slow"], "delay", "p95"),
        "aiortc_fps": median("aiortc", ["slow"], "fps"),
        "aiortc_p50_ms": 1000 * plain,
        "aiortc_p95_ms": 1000 * median("aiortc", ["slow"], "delay", "p95"),
        "p50_ratio": slow / plain,
        "fast_fps": median("openrois", FAST, "fps"),
        "fast_p50_ms": 1000 * median("openrois", FAST, "delay", "p50"),
        "fast_fps_without_slow": median("fast alone", FAST, "fps"),
        "fast_p50_ms_without_slow": 1000 * median("fast alone", FAST, "delay", "p50"),
        "repairs_per_second": max(each["repairs_per_second"] for each in ours),
        "loads": [round(each["load"], 1) for each in results if each["loss"] == loss],
    }


async def measure(chosen: argparse.Namespace) -> list[dict[str, Any]]:
    """All rounds, each with every way in turn."""
    results = []
    async with AsyncExitStack() as stack:
        ours = await stack.enter_async_context(partner("benchmarks.slow_viewer.sender", "openrois", chosen.codec))
        plain = await stack.enter_async_context(partner("benchmarks.slow_viewer.sender", "aiortc", chosen.plain_codec))
        viewers = await stack.enter_async_context(partner("benchmarks.slow_viewer.viewers"))
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
    parser = argparse.ArgumentParser(prog="benchmarks.slow_viewer")
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
    summaries = [summary(results, loss) for loss in chosen.loss]
    for each in summaries:
        print(json.dumps({key: round(value, 3) if isinstance(value, float) else value for key, value in each.items()}))
    if chosen.json is not None:
        chosen.json.write_text(
            json.dumps(
                {
                    "command": " ".join(["benchmarks.slow_viewer", *sys.argv[1:]]),
                    "conditions": conditions(load_before).model_dump(),
                    "summary": summaries,
                    "results": results,
                },
                indent=1,
            )
            + "\n"
        )


if __name__ == "__main__":
    main()
