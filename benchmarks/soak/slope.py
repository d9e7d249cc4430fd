"""How fast something grows, from noisy samples. Pure."""

from collections.abc import Sequence
from itertools import combinations
from statistics import median

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
    return median(slopes)
