"""After a restart applications wait until the former adapters are back, or for a moment."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import Final

from openrois.engine.tree import TreeChange
from openrois.session.session import EngineHost

__all__ = ["RestartBarrier"]

_log = logging.getLogger(__name__)

RETURN_TIME: Final = 3.0
"""Seconds that adapters have: each tries to connect at least every second."""


class RestartBarrier:
    """The engines that the journal knows, and those that are attached now.

    Args:
        host: the gateway's engine, which has none yet.
        sleep: waits for some seconds.
    """

    def __init__(self, host: EngineHost, sleep: Callable[[float], Awaitable[None]] = asyncio.sleep) -> None:
        self._host = host
        self._sleep = sleep
        self._missing = set(host.journal.engines)
        self._over = asyncio.Event()

    @property
    def is_over(self) -> bool:
        """Whether all are back, or the time is over."""
        return self._over.is_set()

    async def wait(self) -> None:
        """Wait until all are back, or the time is over."""
        await self._over.wait()

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Watch the engines, and keep the journal's list of them, while the block runs."""
        self._end_if_complete()
        if not self.is_over:
            _log.info("applications wait for engines that were there before: %s", ", ".join(sorted(self._missing)))
            self._host.tasks.start(self._give_up())
        stop_listening = self._host.engine.changes.add(self._tree_changed)
        try:
            yield
        finally:
            stop_listening()

    def _tree_changed(self, change: TreeChange) -> None:
        if self._host.draining:
            return
        for engine_id in (change.engines_before ^ change.engines_now) - {self._host.engine.engine_id}:
            self._host.journal.engine(engine_id, is_there=engine_id in change.engines_now)
        self._missing -= change.engines_now
        self._end_if_complete()

    def _end_if_complete(self) -> None:
        if not self._missing:
            self._over.set()

    async def _give_up(self) -> None:
        await self._sleep(RETURN_TIME)
        for engine_id in sorted(self._missing):
            _log.warning("%s was there before the restart and is not back", engine_id)
            self._host.journal.engine(engine_id, is_there=False)
        self._missing.clear()
        self._end_if_complete()
