"""What the benchmarks of clusters have alike: progress while they run, and their figures in the end."""

import sys
from collections.abc import Callable, Coroutine, Mapping
from pathlib import Path
from typing import Any

import uvloop

from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.result import write_result

__all__ = ["measure_and_report"]


def measure_and_report(
    module: str,
    measured: Callable[[Callable[[str], None]], Coroutine[Any, Any, Mapping[str, Any]]],
    printed: Callable[[Mapping[str, Any]], str],
    file: Path | None,
) -> None:
    """Measure, print the figures with the machine they were measured on, and write them to a file if one is given.

    Args:
        module: of the benchmark, as `python -m` has it.
        measured: measures, tells its progress, and returns the figures.
        printed: returns the figures as a table.
        file: is written, as JSON; None for no file.
    """
    before = load()
    figures = uvloop.run(measured(_report_progress))
    met = conditions(before, {})
    print(f"{met}\n\n{printed(figures)}")
    write_result(file, module, met, summary=figures)


def _report_progress(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
