"""Waits for an event, for some seconds at most."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

__all__ = ["Sleep", "happens"]

Sleep = Callable[[float], Awaitable[None]]
"""Waits for some seconds."""


async def happens(event: asyncio.Event, within: float, sleep: Sleep) -> bool:
    """Wait for an event, for some seconds at most, and return whether it came."""
    waiting, passing = asyncio.ensure_future(event.wait()), asyncio.ensure_future(sleep(within))
    both: set[asyncio.Future[Any]] = {waiting, passing}
    try:
        await asyncio.wait(both, return_when=asyncio.FIRST_COMPLETED)
        return waiting.done()
    finally:
        for each in both:
            each.cancel()
        await asyncio.wait(both)
