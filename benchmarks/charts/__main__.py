"""`python -m benchmarks.charts`: draws the charts of `docs` from the results that are there."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.charts import congestion, fanout, latency

ROOT = Path(__file__).parents[2]
CHARTS: dict[str, tuple[str, Callable[[dict[str, Any]], str]]] = {
    "docs/fanout.svg": ("benchmarks/results/peers.json", fanout.draw),
    "docs/latency.svg": ("benchmarks/results/latency.json", latency.draw),
    "docs/congestion.svg": ("benchmarks/results/slow_viewer.json", congestion.draw),
}
"""Each chart, and what it is drawn from."""


def main() -> None:
    """Draw them."""
    for chart, (result, draw) in CHARTS.items():
        if not (ROOT / result).is_file():
            print(f"{result} is not there: no {chart}")
            continue
        (ROOT / chart).write_text(draw(json.loads((ROOT / result).read_text())))
        print(chart)


if __name__ == "__main__":
    main()
