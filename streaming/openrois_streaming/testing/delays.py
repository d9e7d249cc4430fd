"""Statistics of measured times: their number and percentiles. Pure."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self


@dataclass(frozen=True, slots=True)
class Delays:
    """Statistics of measured times, in seconds.

    Attributes:
        count: number of measurements.
        p50: the median.
        p95: the value that 95 % of them do not exceed.
        p99: the value that 99 % of them do not exceed.
        longest: the longest.
    """

    count: int
    p50: float
    p95: float
    p99: float
    longest: float

    @classmethod
    def of(cls, seconds: Iterable[float]) -> Self | None:
        """Return the statistics of `seconds`; None without measurements."""
        measured = sorted(seconds)
        if not measured:
            return None
        p50, p95, p99 = (percentile(measured, share) for share in (0.5, 0.95, 0.99))
        return cls(len(measured), p50, p95, p99, measured[-1])


def percentile(values: Sequence[float], share: float) -> float:
    """Return the smallest of `values`, one or more, that a `share` (above 0, at most 1) of them does not exceed."""
    return sorted(values)[math.ceil(share * len(values)) - 1]
