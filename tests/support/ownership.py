"""Gateways that share a store, with clocks that tests turn: over the memory of a process, and over PostgreSQL."""

import asyncio
from collections.abc import AsyncIterator, Iterable
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Final, Protocol

from openrois.ownership.claims import Owner
from openrois.ownership.directorate import Directorate
from openrois.ownership.memory_store import MemoryStore
from openrois.ownership.rules import TTL
from openrois.ownership.store import OwnershipStore
from tests.support.clock import Clock
from tests.support.postgres import Server

__all__ = ["NOW_MS", "PATIENT", "Stored", "World", "blocks_overlap", "in_memory", "in_postgres", "never", "until_owned"]

NOW_MS: Final = 1_900_000_000_000
"""The store's clock when a world begins."""

PATIENT: Final = 60.0
"""Seconds that a call may take where its time is not what is tested."""

_TABLES: Final = ("claim", "gateway")


async def never(_seconds: float) -> None:
    """Sleep without an end: a directorate with this renews when it is told to."""
    await asyncio.Event().wait()


class Stored(Protocol):
    """A store, as tests move it."""

    async def connect(self, gateway_id: str) -> OwnershipStore:
        """Return the store as one gateway has it."""
        ...

    async def set_clock(self, now_ms: int) -> None:
        """Set the store's clock."""
        ...

    async def keep_copy(self) -> None:
        """Keep what is in the store now."""
        ...

    async def lose_commits(self) -> None:
        """Go back to what was kept."""
        ...


@dataclass
class World:
    """Gateways and their store. The clocks of all gateways run alike, unless a test turns one."""

    stored: Stored
    stack: AsyncExitStack
    now_ms: int = NOW_MS
    clocks: dict[str, Clock] = field(default_factory=dict)

    async def gateway(self, gateway_id: str, ttl: float = TTL) -> Directorate:
        """Begin as a gateway, which renews when `renew` is called."""
        clock = self.clocks.setdefault(gateway_id, Clock(now=1000.0 * (1 + len(self.clocks))))
        store = await self.stored.connect(gateway_id)
        directorate = Directorate(store, gateway_id, ttl=ttl, patience=PATIENT, clock=clock, sleep=never)
        return await self.stack.enter_async_context(directorate)

    async def advance(self, seconds: float, *renewing: Directorate) -> None:
        """Let time pass, second by second; these gateways renew after each."""
        while seconds > 0:
            passed = min(1.0, seconds)
            seconds -= passed
            for clock in self.clocks.values():
                clock.now += passed
            await self.step_clock(passed)
            for each in renewing:
                await each.renew()

    async def step_clock(self, seconds: float) -> None:
        """Step the store's clock alone."""
        self.now_ms += round(seconds * 1000)
        await self.stored.set_clock(self.now_ms)


async def until_owned(directorate: Directorate, engine_id: str, gateway_id: str) -> Owner | None:
    """Wait until a gateway knows an engine as owned by another, or by none where that is empty."""
    with directorate.watch() as changes:
        async with asyncio.timeout(PATIENT):
            while (owner := directorate.owners.get(engine_id)) is None or owner.gateway_id != gateway_id:
                if owner is None and not gateway_id:
                    break
                await anext(changes)
    return owner


class _InMemory:
    def __init__(self) -> None:
        self.clock = Clock(NOW_MS / 1000)
        self.store = MemoryStore(self.clock)
        self.copy: tuple[dict[str, Any], dict[str, Any]] = {}, {}

    async def connect(self, gateway_id: str) -> OwnershipStore:
        return self.store

    async def set_clock(self, now_ms: int) -> None:
        self.clock.now = now_ms / 1000

    async def keep_copy(self) -> None:
        self.copy = dict(self.store.records), dict(self.store.gateways)

    async def lose_commits(self) -> None:
        self.store.records, self.store.gateways = dict(self.copy[0]), dict(self.copy[1])


@asynccontextmanager
async def in_memory() -> AsyncIterator[World]:
    """Make a world over the memory of this process."""
    async with AsyncExitStack() as stack:
        yield World(_InMemory(), stack)


class _InPostgres:
    def __init__(self, server: Server, stack: AsyncExitStack, admin: Any) -> None:
        self._server = server
        self._stack = stack
        self.admin = admin

    async def connect(self, gateway_id: str) -> OwnershipStore:
        from openrois.cluster.postgres.database import Database
        from openrois.cluster.postgres.ownership import PostgresStore

        database = Database(self._server.url, self._server.password_file, gateway_id=gateway_id)
        return PostgresStore(await self._stack.enter_async_context(database), now="tests.now()")

    async def set_clock(self, now_ms: int) -> None:
        await self.admin.execute("UPDATE tests.clock SET now = $1", now_ms)

    async def keep_copy(self) -> None:
        for table in _TABLES:
            await self.admin.execute(f"CREATE TABLE tests.{table} AS TABLE openrois.{table}")

    async def lose_commits(self) -> None:
        for table in _TABLES:
            await self.admin.execute(
                f"DELETE FROM openrois.{table}; INSERT INTO openrois.{table} SELECT * FROM tests.{table}"
            )


@asynccontextmanager
async def in_postgres(server: Server) -> AsyncIterator[World]:
    """Make a world over an empty PostgreSQL database, whose clock stands still."""
    async with server.admin() as admin, AsyncExitStack() as stack:
        await admin.execute(f"""
            DROP SCHEMA IF EXISTS openrois CASCADE; DROP SCHEMA IF EXISTS tests CASCADE; CREATE SCHEMA tests;
            CREATE TABLE tests.clock AS SELECT {NOW_MS}::bigint AS now;
            CREATE FUNCTION tests.now() RETURNS bigint LANGUAGE sql VOLATILE AS 'SELECT now FROM tests.clock';
        """)
        yield World(_InPostgres(server, stack, admin), stack)


def blocks_overlap(blocks: Iterable[tuple[int, int]]) -> bool:
    """Tell whether any two blocks of epochs have one in common."""
    ordered = sorted(blocks)
    return any(one[1] >= other[0] for one, other in pairwise(ordered))
