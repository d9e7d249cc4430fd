"""Writes which components are held to the store in the background, so that leases do not wait for it."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from contextlib import AbstractAsyncContextManager
from itertools import islice
from types import TracebackType
from typing import Final, Self

from openrois.aio.write_loop import WriteLoop
from openrois.errors import StoreUnreachable
from openrois.resumption.lines import Change
from openrois.resumption.store import ResumeStore

__all__ = ["DRAIN_TIME", "MAX_CHANGES", "HoldingsWriter"]

_log = logging.getLogger(__name__)

MAX_CHANGES: Final = 65_536
"""Components whose last change waits to be written; of more the oldest is dropped, and counted."""

DRAIN_TIME: Final = 2.0
"""Seconds that the end of a gateway waits for what is not written."""

_BATCH: Final = 512


class HoldingsWriter(AbstractAsyncContextManager["HoldingsWriter"]):
    """The way of one gateway's leases into the store. Enter it as long as the gateway runs.

    Of each component the last change alone waits, so that a store that was away learns how it ended. Leaving the block
    writes what waits, for at most `DRAIN_TIME`.

    Args:
        store: where holdings are kept.
        sleep: waits for some seconds.
        most: changes that may wait.

    Attributes:
        problem: why the store does not take changes; empty where it does.
        lost: changes that were dropped because too many waited.
        failures: how often the store did not take a batch.
    """

    def __init__(
        self,
        store: ResumeStore,
        *,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        most: int = MAX_CHANGES,
    ) -> None:
        self.problem = ""
        self.lost = 0
        self.failures = 0
        self._store = store
        self._most = most
        self._waiting: dict[str, Change] = {}
        self._loop = WriteLoop(lambda: bool(self._waiting), self._write, sleep)

    async def __aenter__(self) -> Self:
        await self._loop.__aenter__()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            if not await self.flushed():
                _log.error("%d changes of holders are not in %s: %s", self.waiting, self._store.name, self.problem)
        finally:
            await self._loop.__aexit__(kind, error, trace)

    @property
    def waiting(self) -> int:
        """Number of changes that wait to be written."""
        return len(self._waiting)

    def note(self, change: Change) -> None:
        """Note a change, which is written soon; one that waits for the same component gives way to it."""
        former = self._waiting.pop(change.component_ref, None)
        if former is not None and former.epoch > change.epoch:
            change = former
        elif len(self._waiting) >= self._most:
            del self._waiting[next(iter(self._waiting))]
            if not self.lost:
                _log.error("changes of holders are lost: more than %d wait for %s", self._most, self._store.name)
            self.lost += 1
        self._waiting[change.component_ref] = change
        self._loop.wake()

    async def flushed(self, seconds: float = DRAIN_TIME) -> bool:
        """Wait until everything is written, or for so long; tell whether it is."""
        return await self._loop.flushed(seconds)

    async def _write(self) -> bool:
        """Write one batch; tell whether that worked."""
        batch = list(islice(self._waiting.values(), _BATCH))
        try:
            await self._store.write(batch)
        except StoreUnreachable as error:
            self.failures += 1
            if not self.problem:
                _log.warning("%s; changes of holders wait: a session that is lost now finds less of them", error)
            self.problem = str(error)
            return False
        for change in batch:
            if self._waiting.get(change.component_ref) is change:
                del self._waiting[change.component_ref]
        if self.problem:
            _log.info("%s takes changes of holders again", self._store.name)
            self.problem = ""
        return True
