"""A store behind a bad network: calls and answers are lost, writes arrive late, hints do not come."""

from collections.abc import Awaitable, Callable, Iterable
from enum import StrEnum
from typing import TypeVar

from openrois.errors import StoreUnreachable
from openrois.ownership.claims import Owner
from openrois.ownership.rules import Reading, Record
from openrois.ownership.store import Hint, OwnershipStore, Renewed

__all__ = ["Fate", "LossyStore"]

T = TypeVar("T")


class Fate(StrEnum):
    """What happens to one call."""

    ARRIVES = "arrives"
    LOST = "lost"
    ANSWER_LOST = "answer lost"
    LATE = "late"
    """The gateway gives up; what it asked for happens when `arrive` is called."""


class LossyStore:
    """An `OwnershipStore` as one gateway reaches it.

    Attributes:
        fates: of the next calls, in their order; every other one arrives.
        is_cut: no call arrives at all.
        is_deaf: no hint arrives.
        calls: the names of calls that were made.
    """

    def __init__(self, store: OwnershipStore) -> None:
        self.name = "the store"
        self.fates: list[Fate] = []
        self.is_cut = False
        self.is_deaf = False
        self.calls: list[str] = []
        self._store = store
        self._late: list[Callable[[], Awaitable[object]]] = []

    async def arrive(self) -> None:
        """Let what is late happen."""
        late, self._late = self._late, []
        for call in late:
            await call()

    async def register(self, gateway_id: str, ttl_ms: int) -> Renewed:
        return await self._carry("register", lambda: self._store.register(gateway_id, ttl_ms))

    async def renew(self, gateway_id: str, run: int, ttl_ms: int) -> Renewed | None:
        return await self._carry("renew", lambda: self._store.renew(gateway_id, run, ttl_ms))

    async def read(self, engine_id: str, gateway_id: str) -> Reading:
        return await self._carry("read", lambda: self._store.read(engine_id, gateway_id))

    async def write(self, record: Record, run: int, seen: Record | None, expired_ms: int | None) -> bool:
        return await self._carry("write", lambda: self._store.write(record, run, seen, expired_ms))

    async def release(self, record: Record, run: int) -> None:
        await self._carry("release", lambda: self._store.release(record, run))

    async def leave(self, gateway_id: str, run: int) -> None:
        await self._carry("leave", lambda: self._store.leave(gateway_id, run))

    async def owners(self, engine_ids: Iterable[str] | None) -> list[Owner]:
        return await self._carry("owners", lambda: self._store.owners(engine_ids))

    def listen(self, hint: Hint) -> Callable[[], None]:
        return self._store.listen(lambda engine_ids: None if self.is_deaf else hint(engine_ids))

    async def _carry(self, name: str, call: Callable[[], Awaitable[T]]) -> T:
        self.calls.append(name)
        fate = self.fates.pop(0) if self.fates else Fate.ARRIVES
        if self.is_cut:
            fate = Fate.LOST
        if fate is Fate.LATE:
            self._late.append(call)
        if fate is Fate.ANSWER_LOST:
            await call()
        if fate is not Fate.ARRIVES:
            raise StoreUnreachable(f"the store: the connection was lost ({fate})")
        return await call()
