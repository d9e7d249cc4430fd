"""`python -m openrois_bench.streams.receiving --rounds 3`: from sent to decoded, `Media` and plain aiortc in turns.

A gateway and a body with pictures that were encoded before (1280x720 at 30 a second, H.264) and a tone (Opus) are one
process, each viewer is another one. Pictures are had as NumPy arrays, as decoded (`i420`) and as `rgb24`.
"""

import argparse
import asyncio
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import medians
from openrois_bench.measuring.result import write_result
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import child
from openrois_bench.streams.receiving.viewer import MEDIA, RECEIVERS

_PACKAGE = "openrois_bench.streams.receiving"
_FIGURES = ("p50_ms", "p95_ms", "per_second", "cpu", "load")


async def measure(rounds: int, media: Sequence[str]) -> list[dict[str, Any]]:
    """Take turns, as often as `rounds` says; returns the medians of each kind of media and receiver."""
    runs: list[dict[str, Any]] = []
    async with child("-m", f"{_PACKAGE}.sender") as sender:
        url, epoch = sender.said.split()
        for number in range(rounds):
            for what in media:
                for receiver in RECEIVERS if number % 2 == 0 else RECEIVERS[::-1]:
                    async with child("-m", f"{_PACKAGE}.viewer", receiver, what, url, epoch) as viewer:
                        found = json.loads(viewer.said)
                    runs.append({"media": what, "receiver": receiver, "load": load()} | found)
                    print(json.dumps(runs[-1]), file=sys.stderr, flush=True)
    return medians(runs, by=("media", "receiver"), of=_FIGURES)


def report(rows: Sequence[dict[str, Any]]) -> str:
    """Return the medians, and those of `Media` in proportion to aiortc's, as a table."""
    cells: list[tuple[str, ...]] = []
    for what in dict.fromkeys(row["media"] for row in rows):
        of = {row["receiver"]: row for row in rows if row["media"] == what}
        cells += [(what, who, *(f"{row[name]:g}" for name in _FIGURES)) for who, row in of.items()]
        ratios = (f"{of['openrois'][name] / of['aiortc'][name]:.2f}" for name in _FIGURES[:-1])
        cells.append((what, "ratio", *ratios, "-"))
    return table(("media", "receiver", *_FIGURES), cells)


def main() -> None:
    """Measure, print the medians, and write them to a file if one is named."""
    parser = argparse.ArgumentParser(
        prog=f"python -m {_PACKAGE}", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=3, help="rounds of each (default 3)")
    parser.add_argument("--media", nargs="+", choices=MEDIA, default=MEDIA, help="what is played (all)")
    parser.add_argument("--json", type=Path, help="where the medians go")
    chosen = parser.parse_args()
    before = load()
    rows = asyncio.run(measure(chosen.rounds, chosen.media))
    print(report(rows))
    write_result(chosen.json, _PACKAGE, conditions(before), summary=rows)


if __name__ == "__main__":
    main()
