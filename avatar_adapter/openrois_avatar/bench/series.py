"""What is said about several measurements of one thing. Pure."""

import math
import statistics
from collections.abc import Iterable, Sequence
from typing import Self

from pydantic import BaseModel, ConfigDict

__all__ = ["Series", "percentile"]


class Series(BaseModel):
    """Several measurements of one thing, in the order in which they were made, and what is said about them."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    count: int
    median: float
    p95: float
    values: tuple[float, ...]

    @classmethod
    def of(cls, values: Iterable[float]) -> Self:
        """Sum up `values`.

        Raises:
            ValueError: there are none.
        """
        kept = tuple(values)
        if not kept:
            raise ValueError("nothing was measured")
        return cls(count=len(kept), median=statistics.median(kept), p95=percentile(kept, 0.95), values=kept)


def percentile(values: Sequence[float], share: float) -> float:
    """The smallest of `values` that at least `share` (above 0, at most 1) of them do not exceed."""
    return sorted(values)[math.ceil(share * len(values)) - 1]
