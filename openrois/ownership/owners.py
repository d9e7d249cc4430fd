"""Owners of engines as one gateway knows them, and watchers that follow their changes."""

import asyncio
from collections import OrderedDict
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType

from openrois.ownership.claims import Owner
from openrois.ownership.store import Digest, digest_of

__all__ = ["OwnerChanges", "Owners"]


class OwnerChanges(AsyncIterator[tuple[str, Owner | None]]):
    """Changes of owners that one reader has not seen yet, of each engine the last one alone.

    So there are never more of them than engines, and a reader that is slow still sees how it ended.
    """

    def __init__(self, owners: Mapping[str, Owner]) -> None:
        self._waiting: OrderedDict[str, Owner | None] = OrderedDict(owners)
        self._more = asyncio.Event()
        self._closed = False

    def add(self, engine_id: str, owner: Owner | None) -> None:
        """Add a change."""
        self._waiting[engine_id] = owner
        self._more.set()

    def close(self) -> None:
        """End the iteration behind the changes that wait."""
        self._closed = True
        self._more.set()

    async def __anext__(self) -> tuple[str, Owner | None]:
        """Return the next engine and its owner; None where it has none."""
        while not self._waiting:
            if self._closed:
                raise StopAsyncIteration
            self._more.clear()
            await self._more.wait()
        return self._waiting.popitem(last=False)


class Owners:
    """Owners by engine, and those that watch them.

    Attributes:
        by_engine: the owner of each engine that has one; it changes with time.
    """

    def __init__(self) -> None:
        self._owners: dict[str, Owner] = {}
        self._digest: Digest | None = None
        self._watchers: set[OwnerChanges] = set()
        self.by_engine: Mapping[str, Owner] = MappingProxyType(self._owners)

    @property
    def digest(self) -> Digest:
        """What a store says that has the same owners."""
        if self._digest is None:
            self._digest = digest_of(self._owners.values())
        return self._digest

    def note(self, engine_id: str, owner: Owner | None) -> None:
        """Note the owner of an engine; what watches is notified where it is another."""
        if self._owners.get(engine_id) == owner:
            return
        self._digest = None
        if owner is None:
            del self._owners[engine_id]
        else:
            self._owners[engine_id] = owner
        for watcher in self._watchers:
            watcher.add(engine_id, owner)

    @contextmanager
    def watch(self) -> Iterator[OwnerChanges]:
        """Yield changes, which begin with all owners of now."""
        changes = OwnerChanges(self._owners)
        self._watchers.add(changes)
        try:
            yield changes
        finally:
            self._watchers.discard(changes)

    def close(self) -> None:
        """End the iteration of every watcher."""
        for watcher in self._watchers:
            watcher.close()
