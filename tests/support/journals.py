"""Journals of gateways that are started again, over a file and over PostgreSQL."""

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from itertools import count
from pathlib import Path
from typing import Any

from openrois.journal.journal import Journal
from openrois.journal.sqlite_journal import SqliteJournal
from tests.support.ownership import PATIENT
from tests.support.postgres import Server

__all__ = ["CONTACT", "MakeJournal", "in_a_file", "in_postgres_journal", "until_written"]

MakeJournal = Callable[[], AbstractAsyncContextManager[Journal]]
"""Begins another run of the gateway, with its journal; the end of the block is that of the process."""

CONTACT = 3600.0
"""Seconds of contact with the store, with which no gateway is spared any more."""


async def until_written(journal: Any) -> None:
    """Wait until no record of a journal in PostgreSQL waits."""
    assert await journal._loop.flushed(PATIENT)


def in_a_file(path: Path) -> MakeJournal:
    """Return what begins runs with a file."""

    @asynccontextmanager
    async def run() -> AsyncIterator[Journal]:
        with SqliteJournal(path) as journal:
            yield journal

    return run


@asynccontextmanager
async def in_postgres_journal(server: Server) -> AsyncIterator[Callable[..., AbstractAsyncContextManager[Any]]]:
    """Empty a database; what comes back begins runs of gateways: by their id, and for how long they are registered."""
    from openrois.cluster.postgres.database import Database
    from openrois.cluster.postgres.journal import PostgresJournal
    from openrois.cluster.postgres.ownership import PostgresStore

    async with server.admin() as admin:
        await admin.execute("DROP SCHEMA IF EXISTS openrois CASCADE")
    async with Database(server.url, server.password_file) as database:
        store = PostgresStore(database)
        unregistered = count(1)

        @asynccontextmanager
        async def run(
            gateway_id: str = "a", ttl_ms: int = 600_000, contact: float = CONTACT, **options: Any
        ) -> AsyncIterator[PostgresJournal]:
            number = (await store.register(gateway_id, ttl_ms)).run if ttl_ms else next(unregistered)
            patient: dict[str, Any] = {"patience": PATIENT, "seconds": PATIENT}
            async with PostgresJournal(database, gateway_id, number, lambda: contact, **patient | options) as journal:
                yield journal

        yield run
