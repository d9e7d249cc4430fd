"""What is said of times that were measured. Pure."""

import math
import statistics
from collections.abc import Sequence
from typing import Self

from pydantic import BaseModel, ConfigDict

__all__ = ["Figures", "Throughput", "Waits", "median"]


class Figures(BaseModel):
    """Figures of a bench: frozen, and nothing else."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Waits(Figures):
    """How long many answers took, in microseconds."""

    count: int
    p50: float
    p95: float
    p99: float

    @classmethod
    def of(cls, seconds: Sequence[float]) -> Self:
        """Sum up one or more times in seconds."""
        ordered = sorted(seconds)
        p50, p95, p99 = (round(ordered[math.ceil(share * len(ordered)) - 1] * 1e6, 1) for share in (0.5, 0.95, 0.99))
        return cls(count=len(ordered), p50=p50, p95=p95, p99=p99)

    @classmethod
    def median(cls, rounds: Sequence[Self]) -> Self:
        """Return the median of each figure over several rounds."""
        return cls(
            count=sum(each.count for each in rounds),
            p50=median([each.p50 for each in rounds]),
            p95=median([each.p95 for each in rounds]),
            p99=median([each.p99 for each in rounds]),
        )


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
        return cls(
            per_second=median([each.per_second for each in rounds]),
            gateway_us=median([each.gateway_us for each in rounds]),
            adapter_us=median([each.adapter_us for each in rounds]),
            load_us=median([each.load_us for each in rounds]),
        )


def median(values: Sequence[float]) -> float:
    """Return the median of one or more values, to a thousandth."""
    return round(statistics.median(values), 3)
