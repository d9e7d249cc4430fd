"""Limits of connections: applications and adapters have separate limits, and one address has few."""

import asyncio
from collections import Counter
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from typing import Final

from aiohttp import web

__all__ = ["ENTERING", "MAX_ADAPTERS", "MAX_APPLICATIONS", "MAX_PER_ADDRESS", "MOST", "ConnectionLimits"]

MAX_APPLICATIONS: Final = 8192
"""Applications at a time, unless configured otherwise; one more is answered 503."""

MAX_ADAPTERS: Final = 1024
"""Adapters at a time, unless configured otherwise; one more is answered 503. Applications take no place of theirs."""

MOST: Final = 1_000_000
"""Connections of one kind that can be configured: each takes an open file, and memory."""

MAX_PER_ADDRESS: Final = 1024
"""Applications at a time from one address, unless configured otherwise; one more is answered 429."""


ENTERING: Final = 4
"""Applications whose WebSockets are opened at the same time; adapters pass those that wait for that."""


async def _at_once() -> None:
    """Wait for nothing."""


class ConnectionLimits:
    """The connections of one gateway, counted.

    Args:
        turned_away: called with the reason whenever there is no place.
        applications: at a time.
        adapters: at a time.
        per_address: applications at a time from one address.
        opening: waited for before an application is let in.

    Attributes:
        most_applications: that are let in.
        most_adapters: that are let in.
        waiting: how many applications wait for `entering`.
    """

    def __init__(
        self,
        turned_away: Callable[[str], None],
        applications: int = MAX_APPLICATIONS,
        adapters: int = MAX_ADAPTERS,
        per_address: int = MAX_PER_ADDRESS,
        opening: Callable[[], Awaitable[None]] = _at_once,
    ) -> None:
        self._turned_away = turned_away
        self.most_applications = applications
        self.most_adapters = adapters
        self._per_address = per_address
        self._opening = opening
        self._applications: Counter[str] = Counter()
        self._adapters = 0
        self.waiting = 0
        self._entering = asyncio.Semaphore(ENTERING)

    @property
    def is_full(self) -> bool:
        """Whether one more application, or one more adapter, would be turned away wherever it comes from."""
        return self._applications.total() >= self.most_applications or self._adapters >= self.most_adapters

    @contextmanager
    def of_application(self, address: str) -> Iterator[None]:
        """Count an application while the block runs.

        Raises:
            HTTPServiceUnavailable: there is none.
            HTTPTooManyRequests: there is none for this address.
        """
        if self._applications.total() >= self.most_applications:
            self._turned_away("full")
            raise web.HTTPServiceUnavailable(text="the gateway's limit of applications is reached\n")
        if self._applications[address] >= self._per_address:
            self._turned_away("too many from one address")
            raise web.HTTPTooManyRequests(text="the limit of connections from your address is reached\n")
        self._applications[address] += 1
        try:
            yield
        finally:
            self._applications[address] -= 1
            if not self._applications[address]:
                del self._applications[address]

    @asynccontextmanager
    async def entering(self) -> AsyncIterator[None]:
        """Let an application in while the block runs, a few at a time, in the order in which they came.

        A crowd that comes back at once leaves the loop free for adapters, which do not wait here.
        """
        self.waiting += 1
        try:
            await self._opening()
            await self._entering.acquire()
        finally:
            self.waiting -= 1
        try:
            yield
            # An application admitted before the wait keeps its turn.
            await asyncio.sleep(0)
        finally:
            self._entering.release()

    @contextmanager
    def of_adapter(self) -> Iterator[None]:
        """Count an adapter while the block runs.

        Raises:
            HTTPServiceUnavailable: there is none.
        """
        if self._adapters >= self.most_adapters:
            self._turned_away("full")
            raise web.HTTPServiceUnavailable(text="the gateway's limit of adapters is reached\n")
        self._adapters += 1
        try:
            yield
        finally:
            self._adapters -= 1
