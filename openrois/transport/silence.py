"""Detects that the other side of a connection is silent: it is pinged, and this side's own pauses do not count."""

import asyncio
from collections.abc import Awaitable, Callable

from openrois.aio.loop_lag import STOOD_STILL

__all__ = ["Silence"]


class Silence:
    """The signs of life from the other side of one connection.

    Attributes:
        received: is set with whatever comes from there.
        reading: whether this side reads now.
    """

    def __init__(self) -> None:
        self.received = asyncio.Event()
        self.reading = False

    async def follows(self, ping: Callable[[], Awaitable[None]], timeout: float) -> bool:
        """Ping, and tell whether the other side, which is read from, stays silent for so many seconds.

        Its answer may wait unread, behind what it has said before and what that takes; or come while this process
        stands still: that is not its fault.
        """
        clock = asyncio.get_running_loop().time
        self.received.clear()
        due = clock() + timeout
        try:
            async with asyncio.timeout(timeout):
                await ping()
                await self.received.wait()
        except TimeoutError:
            return self.reading and not self.received.is_set() and clock() < due + STOOD_STILL
        return False
