"""The engines behind a gateway as the client knows them: read in pages once, and then only those that have changed."""

import asyncio
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Final

from openrois.client.subscriptions import Asker
from openrois.types.directory import (
    MAX_PAGE,
    DirectoryChangedNotification,
    DirectoryListParams,
    DirectoryListResult,
    DirectoryReadParams,
    DirectoryReadResult,
    EngineEntry,
)

__all__ = ["EngineDirectory", "Generations"]

MAX_COUNTED: Final = 4096
"""Engines whose changes are counted each; of more all count as changed."""


class Generations:
    """Counts of changes: of what an application has read of an engine each is valid for one count."""

    def __init__(self) -> None:
        self.total = 0
        self._common = 0
        self._own: dict[str, int] = {}

    def of(self, engine_id: str) -> tuple[int, int]:
        """Return the count of an engine's changes, which never returns to a former one."""
        return self._common, self._own.get(engine_id, 0)

    def count_all(self) -> None:
        """Count a change of any engine."""
        self.total += 1
        self._common += 1
        self._own.clear()

    def count(self, engine_ids: Iterable[str]) -> None:
        """Count a change of some engines."""
        self.total += 1
        for engine_id in engine_ids:
            self._own[engine_id] = self._own.get(engine_id, 0) + 1
        if len(self._own) > MAX_COUNTED:
            self.count_all()


class EngineDirectory:
    """The entries of all engines; for gateways that speak `openrois.directory`.

    Args:
        asker: returns the connection to the gateway.
    """

    def __init__(self, asker: Callable[[], Asker]) -> None:
        self._asker = asker
        self._entries: dict[str, EngineEntry] = {}
        self._stale: dict[str, None] = {}
        self._is_listed = False
        self._lists = 0
        """Counts how often the whole list became invalid."""
        self._reading = asyncio.Lock()

    def reset(self) -> None:
        """Note that there is another connection, perhaps to another gateway, or that too much has changed."""
        self._lists += 1
        self._is_listed = False
        self._entries.clear()
        self._stale.clear()

    def note_changes(self, notice: DirectoryChangedNotification) -> None:
        """Note which engines have changed."""
        if notice.unnamed:
            self.reset()
            return
        self._stale.update(dict.fromkeys(notice.changed))
        for engine_id in notice.gone:
            self._entries.pop(engine_id, None)
            self._stale.pop(engine_id, None)

    async def read(self) -> Mapping[str, EngineEntry]:
        """Return the entries of all engines by their ids, as they are now; only what has changed is asked for.

        Raises:
            RoISError, ConnectionLost, TimeoutError: as every question.
        """
        async with self._reading:
            # What has changed and is not told of yet is told before the reply: at least one is waited for.
            is_fresh = False
            while not (is_fresh and self._is_listed and not self._stale):
                await (self._read_stale() if self._is_listed else self._list())
                is_fresh = True
            return MappingProxyType(dict(self._entries))

    async def _list(self) -> None:
        lists, after = self._lists, ""
        while True:
            page = await self._asker().ask(
                "openrois.directory.list",
                DirectoryListParams(after=after),
                DirectoryListResult,
                lambda page: self._keep(page.engines, lists),
            )
            if lists != self._lists:
                return
            if page.next <= after:
                # The last one; a gateway whose pages do not go on would be asked for ever.
                self._is_listed = True
                return
            after = page.next

    async def _read_stale(self) -> None:
        some = tuple(self._stale)[:MAX_PAGE]
        lists = self._lists

        def accepted(result: DirectoryReadResult) -> None:
            # In the order of the connection: what changes from here on is noted again.
            for engine_id in set(some) - set(result.left):
                self._stale.pop(engine_id, None)
            self._keep(result.engines, lists)

        await self._asker().ask(
            "openrois.directory.read", DirectoryReadParams(engine_ids=some), DirectoryReadResult, accepted
        )

    def _keep(self, engines: Iterable[EngineEntry], lists: int) -> None:
        """Keep entries, unless the list has become invalid since they were asked for."""
        if lists == self._lists:
            self._entries.update({entry.engine_id: entry for entry in engines})
