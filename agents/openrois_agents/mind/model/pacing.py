"""Notices pauses in what arrives, so that a sentence need not wait for the next one to begin."""

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator
from typing import TypeVar

__all__ = ["with_pauses"]

T = TypeVar("T")


async def with_pauses(source: AsyncIterator[T], seconds: float) -> AsyncGenerator[T | None]:
    """Yield what arrives, and None once in each pause of so many seconds; close it, so that nothing is read on."""
    while True:
        reading = asyncio.ensure_future(_next(source))
        try:
            if not (await asyncio.wait({reading}, timeout=seconds))[0]:
                yield None
                await asyncio.wait({reading})
        finally:
            if not reading.done():
                reading.cancel()
                await asyncio.wait({reading})
        found = reading.result()
        if not found:
            return
        yield found[0]


async def _next(source: AsyncIterator[T]) -> tuple[T, ...]:
    """Return the next one, nothing at the end: a task cannot raise what ends an iteration."""
    try:
        return (await anext(source),)
    except StopAsyncIteration:
        return ()
