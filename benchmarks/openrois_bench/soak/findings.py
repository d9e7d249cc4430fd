"""Common parts of the soaks: samples, scraped figures, and leftovers."""

import asyncio
import time
import urllib.request
from collections.abc import Awaitable, Callable, Mapping
from typing import Final, TypeVar

from prometheus_client.parser import text_string_to_metric_families

__all__ = ["INTERVAL", "figures", "is_clean", "left_over", "sampled"]

INTERVAL: Final = 2.0
"""Seconds between two samples."""

Sample = TypeVar("Sample")


async def sampled(take: Callable[[], Awaitable[Sample]], seconds: float) -> list[Sample]:
    """Take samples for so long, the last one at the end of it."""
    samples = []
    end = time.monotonic() + seconds
    while True:
        samples.append(await take())
        if time.monotonic() >= end:
            return samples
        await asyncio.sleep(INTERVAL)


def figures(url: str) -> dict[str, float]:
    """Return the figures without labels that a process serves for Prometheus at `url`."""
    with urllib.request.urlopen(url, timeout=10) as response:
        families = text_string_to_metric_families(response.read().decode())
    return {sample.name: sample.value for family in families for sample in family.samples if not sample.labels}


def left_over(before: object, after: object, *names: str) -> dict[str, int]:
    """Return by how much each of the attributes has grown from one moment at rest to another."""
    return {name: getattr(after, name) - getattr(before, name) for name in names}


def is_clean(left: Mapping[str, int]) -> bool:
    """Tell whether nothing is left over."""
    return not any(value > 0 for value in left.values())
