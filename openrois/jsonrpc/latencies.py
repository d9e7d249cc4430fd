"""Durations of calls, by method: a histogram for each, cheap enough to be kept for every call. Pure."""

from bisect import bisect_left
from collections.abc import Iterator
from typing import Final

__all__ = ["BOUNDS", "Latencies"]

BOUNDS: Final = (0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1.0, 2.5, 5.0, 10.0)
"""Seconds: the upper bounds of the buckets; what took longer is in one more."""


class Latencies:
    """The calls of one kind since the start. Only known methods may be noted: each is kept for ever."""

    def __init__(self) -> None:
        # For each method the count of each bucket, and at the end the seconds of all.
        self._of: dict[str, list[float]] = {}

    def note(self, method: str, seconds: float) -> None:
        """Count a call that took so long."""
        noted = self._of.get(method)
        if noted is None:
            noted = self._of[method] = [0] * (len(BOUNDS) + 2)
        noted[bisect_left(BOUNDS, seconds)] += 1
        noted[-1] += seconds

    def __iter__(self) -> Iterator[tuple[str, list[int], float]]:
        """Yield each method with the counts of its buckets, and the sum of its durations."""
        for method, noted in self._of.items():
            yield method, [int(count) for count in noted[:-1]], noted[-1]
