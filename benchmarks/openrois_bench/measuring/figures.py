"""Statistics of a bench: percentiles, medians over rounds, and how fast something grows. Pure."""

import math
import statistics
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from typing import Any, Final, Self

from pydantic import BaseModel, ConfigDict

__all__ = ["MICROSECONDS", "MILLISECONDS", "Figures", "Percentiles", "Throughput", "median", "medians"]

MILLISECONDS: Final = 1e3
MICROSECONDS: Final = 1e6
"""Of a second: what values in seconds are multiplied by."""


class Figures(BaseModel):
    """Figures of a bench: frozen, and nothing else."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Percentiles(Figures):
    """Number and percentiles of measured values, in the unit of the field that holds them."""

    count: int
    p50: float
    p95: float
    p99: float

    @classmethod
    def of(cls, values: Iterable[float], scale: float = 1.0) -> Self:
        """Sum up values, each multiplied by `scale`.

        Each percentile is the smallest of the values that so many per cent of them do not exceed.

        Raises:
            ValueError: there are none.
        """
        ordered = sorted(values)
        if not ordered:
            raise ValueError("there are no values to sum up: measure at least once")
        p50, p95, p99 = (round(ordered[math.ceil(share * len(ordered)) - 1] * scale, 3) for share in (0.5, 0.95, 0.99))
        return cls(count=len(ordered), p50=p50, p95=p95, p99=p99)

    @classmethod
    def median(cls, rounds: Sequence[Self]) -> Self:
        """Return the median of each figure over several rounds, and how many values all of them had."""
        found = {name: median([getattr(each, name) for each in rounds]) for name in ("p50", "p95", "p99")}
        return cls(count=sum(each.count for each in rounds), **found)


class Throughput(Figures):
    """Many at a time: how many a second, and microseconds of each process for one."""

    per_second: float
    gateway_us: float
    adapter_us: float
    load_us: float

    @classmethod
    def of(cls, count: int, took: float, *, gateway: float, adapter: float, load: float) -> Self:
        """Say it of so many that took so many seconds in all, and so many of each process."""
        gateway_us, adapter_us, load_us = (seconds / count * 1e6 for seconds in (gateway, adapter, load))
        return cls(per_second=count / took, gateway_us=gateway_us, adapter_us=adapter_us, load_us=load_us)

    @classmethod
    def median(cls, rounds: Sequence[Self]) -> Self:
        """Return the median of each figure over several rounds."""
        return cls(**{name: median([getattr(each, name) for each in rounds]) for name in cls.model_fields})


def median(values: Sequence[float]) -> float:
    """Return the median of one or more values, to a thousandth."""
    return round(statistics.median(values), 3)


def medians(runs: Sequence[Mapping[str, Any]], by: Sequence[str], of: Sequence[str]) -> list[dict[str, Any]]:
    """Return a row for all runs that are alike in what `by` names, with the median of each figure that `of` names.

    Rows stand in the order in which the first run of each was made; `runs` says how many each is of.
    """
    alike: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for run in runs:
        alike.setdefault(tuple(run[name] for name in by), []).append(run)
    rows = []
    for cell, its in alike.items():
        found = {name: round(statistics.median(run[name] for run in its), 6) for name in of}
        rows.append({**dict(zip(by, cell, strict=True)), **found, "runs": len(its)})
    return rows


PAIRS = 200_000
"""Pairs that are looked at, at most; from more samples every other one is left out until they are as few."""


def slope(samples: Sequence[tuple[float, float]]) -> float:
    """The median of the slopes between all pairs of (time, value): Theil-Sen, which outliers do not bend.

    Raises:
        ValueError: fewer than two samples, or all of one moment.
    """
    chosen = list(samples)
    while len(chosen) * (len(chosen) - 1) // 2 > PAIRS:
        chosen = chosen[::2]
    slopes = [
        (later[1] - first[1]) / (later[0] - first[0])
        for first, later in combinations(chosen, 2)
        if later[0] != first[0]
    ]
    if not slopes:
        raise ValueError("a slope needs samples of two moments")
    return statistics.median(slopes)
