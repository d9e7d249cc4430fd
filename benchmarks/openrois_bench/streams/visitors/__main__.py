"""`python -m openrois_bench.streams.visitors`: what visitors cost the avatar adapter, in processor time and memory.

Run it in the folder of a clone. Gateway, adapter, visitors and listeners are processes of their own; the adapter shows
test pictures that are not watched. With `recognised` an application listens to all senses of camera and microphone.
"""

import argparse
import asyncio
import json
import sys
import time
from collections.abc import Sequence
from contextlib import AsyncExitStack
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from openrois.client import Client, where
from openrois.types.references import reference
from openrois_bench.clone import require_clone
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import medians
from openrois_bench.measuring.result import write_result
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import Child
from openrois_bench.processes.partner import partner
from openrois_bench.viewing.adapter import ENGINE_ID
from openrois_bench.viewing.product import product

PATIENCE: Final = 60.0
"""Seconds that visitors and listeners have until all that they send and receive arrives."""

SENSED: Final = {
    "speech_recognizer": "speech_recognized",
    "sound_detecter": "sound_detected",
    "face_detecter": "face_detected",
    "person_detecter": "person_detected",
}
"""Senses that are listened to, and of each an event."""

_FIGURES: Final = ("cpu", "megabytes", "relayed_pictures", "relayed_blocks", "load")


@dataclass(frozen=True, slots=True)
class Case:
    """What is measured: so many visitors, what each sends, and who listens."""

    visitors: int
    sent: str
    listeners: int
    recognised: bool = False


CASES: Final = (
    Case(0, "-", 0),
    *(
        Case(visitors, sent, listeners)
        for sent in ("microphone", "camera")
        for visitors in (1, 8)
        for listeners in (0, 2)
    ),
    Case(1, "camera", 0, recognised=True),
    Case(8, "camera", 0, recognised=True),
)
"""A visitor that sends a camera sends a microphone, too."""


async def measure(case: Case, size: tuple[int, int], fps: float, settling: float, seconds: float) -> dict[str, Any]:
    """Measure one case with processes of its own."""
    async with AsyncExitStack() as stack:
        served = await stack.enter_async_context(product(640, 360))
        visitor = ("openrois_bench.streams.visitors.visitor", served.url, case.sent, *map(str, size), str(fps))
        for _ in range(case.visitors):
            await (await stack.enter_async_context(partner(*visitor))).ask("run", {}, within=PATIENCE)
        listeners = [
            await stack.enter_async_context(partner("openrois_bench.streams.visitors.listener", served.url))
            for _ in range(case.listeners)
        ]
        for each in listeners:
            await each.ask("run", {}, within=PATIENCE)
        if case.recognised:
            client = await stack.enter_async_context(Client(served.url, reconnect=None))
            for name, event in SENSED.items():
                subscription = client.subscribe(event, where(component_ref=reference(ENGINE_ID, name)))
                await stack.enter_async_context(subscription)
        await asyncio.sleep(settling)
        adapter = Child(served.adapter, "")
        counted = [await each.ask("count", {}, within=PATIENCE) for each in listeners]
        used, began = adapter.cpu(), time.monotonic()
        await asyncio.sleep(seconds)
        took, used = time.monotonic() - began, adapter.cpu() - used
        came = [await each.ask("count", {}, within=PATIENCE) for each in listeners]
        return {
            "cpu": round(used / took, 4),
            "megabytes": round(adapter.memory() * 1.048576, 1),
            "relayed_pictures": _rate(counted, came, "camera", took),
            "relayed_blocks": _rate(counted, came, "microphone", took),
        }


def _rate(before: Sequence[dict[str, int]], after: Sequence[dict[str, int]], device: str, took: float) -> float:
    """Return how much of a device each listener got in a second, on average."""
    gained = [late.get(device, 0) - early.get(device, 0) for early, late in zip(before, after, strict=True)]
    return round(sum(gained) / took / max(1, len(gained)), 1)


async def measure_all(chosen: argparse.Namespace) -> list[dict[str, Any]]:
    """Measure all cases, as often as is wanted; return the median of each."""
    runs: list[dict[str, Any]] = []
    for number in range(chosen.rounds):
        for case in CASES if number % 2 == 0 else CASES[::-1]:
            if case.visitors in chosen.visitors:
                found = await measure(case, tuple(chosen.size), chosen.fps, chosen.settling, chosen.seconds)
                runs.append(asdict(case) | found | {"load": load()})
                print(json.dumps(runs[-1]), file=sys.stderr)
    return medians(runs, by=("visitors", "sent", "listeners", "recognised"), of=_FIGURES)


def told(rows: Sequence[dict[str, Any]]) -> str:
    """Return the rows as a table; `camera` is camera and microphone."""
    head = ("visitors", "sent", "listeners", "recognised", "cores", "MB", "pictures/s", "blocks/s", "load")
    names = ("visitors", "sent", "listeners", "recognised", *_FIGURES)
    return table(head, [[_cell(row[name]) for name in names] for row in rows])


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.3f}" if isinstance(value, float) and value < 1 else str(value)


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure and tell."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.streams.visitors", description=__doc__)
    parser.add_argument("--rounds", type=int, default=3, help="rounds of all cases (%(default)s)")
    parser.add_argument("--seconds", type=float, default=20.0, help="that each case is measured (%(default)s)")
    parser.add_argument("--settling", type=float, default=8.0, help="seconds before that (%(default)s)")
    parser.add_argument("--visitors", type=int, nargs="+", default=[0, 1, 8], help="only with so many (0 1 8)")
    parser.add_argument("--size", type=int, nargs=2, default=[640, 360], help="of the cameras (640 360)")
    parser.add_argument("--fps", type=float, default=15.0, help="of the cameras (%(default)s)")
    parser.add_argument("--json", type=Path, help="where the medians go")
    chosen = parser.parse_args(arguments)
    require_clone()
    before = load()
    rows = asyncio.run(measure_all(chosen))
    print(told(rows))
    write_result(chosen.json, "openrois_bench.streams.visitors", conditions(before), summary=rows)


if __name__ == "__main__":
    main()
