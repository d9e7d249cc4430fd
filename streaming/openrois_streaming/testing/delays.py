"""What is said about many measurements of one thing: how many, and their percentiles. Pure."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Self


@dataclass(frozen=True, slots=True)
class Delays:
    """Measured times, all in seconds.

    Attributes:
        count: how many were measured; the others are of these.
        p50: the median.
        p95: what 95 % of them do not exceed.
        p99: what 99 % of them do not exceed.
        longest: the longest.
    """

    count: int
    p50: float
    p95: float
    p99: float
    longest: float

    @classmethod
    def of(cls, seconds: Iterable[float]) -> Self | None:
        """Sum up what was measured; None if nothing was."""
        measured = sorted(seconds)
        if not measured:
            return None
        p50, p95, p99 = (percentile(measured, share) for share in (0.5, 0.95, 0.99))
        return cls(len(measured), p50, p95, p99, measured[-1])


def percentile(values: Sequence[float], share: float) -> float:
    """The smallest of `values`, one or more, that at least `share` (above 0, at most 1) of them do not exceed."""
    return sorted(values)[math.ceil(share * len(values)) - 1]
