"""A resume store with a clock that tests turn: over the memory of a process, and over PostgreSQL."""

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Final

from openrois.resumption.memory_store import MemoryResumeStore
from openrois.resumption.store import ResumeStore
from tests.support.clock import Clock
from tests.support.ownership import NOW_MS, PATIENT
from tests.support.postgres import Server

__all__ = ["Kept", "kept_in_memory", "kept_in_postgres"]

_START: Final = NOW_MS / 1000


@dataclass
class Kept:
    """A store as two gateways have it.

    Attributes:
        store: as one of them has it.
        other: as the other has it.
        advance: lets seconds pass at the store.
        count: the number of lines, tokens and components that it keeps.
    """

    store: ResumeStore
    other: ResumeStore
    advance: Callable[[float], Awaitable[None]]
    count: Callable[[], Awaitable[tuple[int, int, int]]]


@asynccontextmanager
async def kept_in_memory() -> AsyncIterator[Kept]:
    """Make a store in the memory of this process."""
    clock = Clock(_START)
    store = MemoryResumeStore(clock)

    async def advance(seconds: float) -> None:
        clock.now += seconds

    async def count() -> tuple[int, int, int]:
        return len(store._lines), len(store._line_ids), len(store._kept)

    yield Kept(store, store, advance, count)


@asynccontextmanager
async def kept_in_postgres(server: Server) -> AsyncIterator[Kept]:
    """Make a store in an empty PostgreSQL database, whose clock stands still."""
    from openrois.cluster.postgres.database import Database
    from openrois.cluster.postgres.resumption import PostgresResumeStore

    async with server.admin() as admin:
        await admin.execute(f"""
            DROP SCHEMA IF EXISTS openrois CASCADE; DROP SCHEMA IF EXISTS tests CASCADE; CREATE SCHEMA tests;
            CREATE TABLE tests.clock AS SELECT {NOW_MS}::bigint AS now;
            CREATE FUNCTION tests.now() RETURNS bigint LANGUAGE sql VOLATILE AS 'SELECT now FROM tests.clock';
        """)

        async def advance(seconds: float) -> None:
            await admin.execute("UPDATE tests.clock SET now = now + $1", round(seconds * 1000))

        async def count() -> tuple[int, int, int]:
            tables = ("resume_line", "resume_token", "holding")
            lines, tokens, held = [await admin.fetchval(f"SELECT count(*) FROM openrois.{each}") for each in tables]
            return lines, tokens, held

        async with (
            Database(server.url, server.password_file, gateway_id="a") as one,
            Database(server.url, server.password_file, gateway_id="b") as two,
        ):
            store, other = (PostgresResumeStore(each, patience=PATIENT, now="tests.now()") for each in (one, two))
            yield Kept(store, other, advance, count)
