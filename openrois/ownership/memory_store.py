"""Ownership in the memory of one process: what a gateway uses that is alone. Pure."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from openrois.aio.listeners import Listeners
from openrois.ownership.claims import Owner
from openrois.ownership.rules import Reading, Record
from openrois.ownership.store import Digest, Hint, Renewed, digest_of

__all__ = ["Gateway", "MemoryStore"]


@dataclass(frozen=True, slots=True)
class Gateway:
    """A gateway as a store keeps it.

    Attributes:
        run: the number of the process that runs as this gateway; a later one has a greater number.
        expires_ms: when its claims expire.
        ttl_ms: how long they hold after a renewal.
    """

    run: int
    expires_ms: int
    ttl_ms: int


class MemoryStore:
    """An `OwnershipStore` of dictionaries and a clock.

    Args:
        clock: epoch seconds.

    Attributes:
        records: what it keeps of engines, by their ids.
        gateways: what it keeps of gateways, by their ids.
    """

    def __init__(self, clock: Callable[[], float]) -> None:
        self.name = "the memory of this gateway"
        self.records: dict[str, Record] = {}
        self.gateways: dict[str, Gateway] = {}
        self._clock = clock
        self._hints: Listeners[Iterable[str] | None] = Listeners()

    async def register(self, gateway_id: str, ttl_ms: int) -> Renewed:
        """Begin as a gateway."""
        former = self.gateways.get(gateway_id)
        now = self._now()
        run = now if former is None else max(now, former.run + 1)
        self.gateways[gateway_id] = Gateway(run, now + ttl_ms, ttl_ms)
        await self.leave(gateway_id, run)
        return Renewed(run, 0, now, self._digest())

    async def renew(self, gateway_id: str, run: int, ttl_ms: int) -> Renewed | None:
        """Prolong all claims of a gateway."""
        now = self._now()
        known = self.gateways.get(gateway_id)
        if known is not None and known.run > run:
            return None
        self.gateways[gateway_id] = Gateway(run, now + ttl_ms, ttl_ms)
        for other, row in self.gateways.items():
            # The clock was stepped back: what has expired would hold for as long as that.
            self.gateways[other] = replace(row, expires_ms=min(row.expires_ms, now + row.ttl_ms))
        return Renewed(run, known.expires_ms if known is not None else 0, now, self._digest())

    async def read(self, engine_id: str, gateway_id: str) -> Reading:
        """Return what a gateway has to know to claim an engine."""
        record = self.records.get(engine_id)
        owner = self.gateways.get(record.gateway_id) if record is not None else None
        asking = self.gateways.get(gateway_id)
        return Reading(
            record=record,
            expires_ms=owner.expires_ms if owner is not None else 0,
            ttl_ms=owner.ttl_ms if owner is not None else 0,
            run=asking.run if asking is not None else 0,
            own_expires_ms=asking.expires_ms if asking is not None else 0,
            now_ms=self._now(),
        )

    async def write(self, record: Record, run: int, seen: Record | None, expired_ms: int | None) -> bool:
        """Write a claim if nothing has changed since it was read."""
        if not self._is_run(record.gateway_id, run) or self.records.get(record.engine_id) != seen:
            return False
        if expired_ms is not None and seen is not None:
            owner = self.gateways.get(seen.gateway_id)
            if owner is None or owner.expires_ms != expired_ms:
                return False
        self.records[record.engine_id] = record
        self._hints.notify_all((record.engine_id,))
        return True

    async def release(self, record: Record, run: int) -> None:
        """Release an engine."""
        if self._is_run(record.gateway_id, run) and self.records.get(record.engine_id) == record:
            self._release(record)

    async def leave(self, gateway_id: str, run: int) -> None:
        """Release all engines of a gateway."""
        if self._is_run(gateway_id, run):
            for record in tuple(self.records.values()):
                if record.gateway_id == gateway_id:
                    self._release(record)

    async def owners(self, engine_ids: Iterable[str] | None) -> list[Owner]:
        """Return owners."""
        wanted = self.records.keys() if engine_ids is None else self.records.keys() & set(engine_ids)
        return [owner for each in wanted if (owner := self.records[each].owner) is not None]

    def listen(self, hint: Hint) -> Callable[[], None]:
        """Call `hint` whenever an owner has changed."""
        return self._hints.add(hint)

    def _release(self, record: Record) -> None:
        self.records[record.engine_id] = replace(record, gateway_id="", instance="")
        self._hints.notify_all((record.engine_id,))

    def _is_run(self, gateway_id: str, run: int) -> bool:
        known = self.gateways.get(gateway_id)
        return known is not None and known.run == run

    def _digest(self) -> Digest:
        return digest_of(owner for record in self.records.values() if (owner := record.owner) is not None)

    def _now(self) -> int:
        return round(self._clock() * 1000)
