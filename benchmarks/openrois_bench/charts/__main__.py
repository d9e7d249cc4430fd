"""`python -m openrois_bench.charts`: draws the charts of `docs` from the results."""

import argparse
import json
from collections.abc import Callable
from typing import Any

from openrois_bench.charts import congestion, latency
from openrois_bench.clone import ROOT, require_clone

CHARTS: dict[str, tuple[str, Callable[[dict[str, Any]], str]]] = {
    "docs/pictures/latency.svg": ("benchmarks/results/latency.json", latency.draw),
    "docs/pictures/congestion.svg": ("benchmarks/results/slow_viewer.json", congestion.draw),
}
"""Each chart, and what it is drawn from."""


def main() -> None:
    """Draw them."""
    parser = argparse.ArgumentParser(
        prog="python -m openrois_bench.charts", description="Draws the charts of the pages."
    )
    parser.parse_args()
    require_clone()
    for chart, (result, draw) in CHARTS.items():
        (ROOT / chart).write_text(draw(json.loads((ROOT / result).read_text())))
        print(chart)


if __name__ == "__main__":
    main()
