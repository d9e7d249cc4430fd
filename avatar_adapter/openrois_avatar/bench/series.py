"""What is said about several measurements of one thing. Pure."""

import statistics
from collections.abc import Iterable
from typing import Self

from openrois_streaming.testing.delays import percentile
from pydantic import BaseModel, ConfigDict

__all__ = ["Series"]


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
