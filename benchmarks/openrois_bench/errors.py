"""Failures of a bench."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

__all__ = ["BenchFailed", "within"]


class BenchFailed(Exception):
    """Failure of a measured program; the text is a sentence for a person."""


@asynccontextmanager
async def within(seconds: float, what: str) -> AsyncIterator[None]:
    """Limit `what` to so many seconds.

    Raises:
        BenchFailed: it took longer.
    """
    try:
        async with asyncio.timeout(seconds):
            yield
    except TimeoutError as error:
        raise BenchFailed(f"{what} took longer than {seconds:.0f} s") from error
