"""Calls of one kind to PostgreSQL: a few at once, so that other kinds find a connection, and each has its end."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Final

from openrois.cluster.postgres.database import Database
from openrois.errors import StoreUnreachable

if TYPE_CHECKING:
    from asyncpg import Connection

__all__ = ["CALL_TIME", "Calls"]

CALL_TIME: Final = 1.0
"""Seconds in which a call has its result or its error, with the wait for its turn."""


class Calls:
    """The calls of one user of a database.

    Args:
        database: it is entered by the caller.
        most: of them that are under way at once; others wait for their turn.
        seconds: in which each has its end.
    """

    def __init__(self, database: Database, most: int, seconds: float = CALL_TIME) -> None:
        self._database = database
        self._seconds = seconds
        self._places = asyncio.Semaphore(most)

    @asynccontextmanager
    async def connection(self) -> "AsyncIterator[Connection]":
        """Yield a connection for one call.

        Raises:
            StoreUnreachable: there is none, or the call failed or took too long; it may have been done.
        """
        try:
            async with asyncio.timeout(self._seconds), self._places, self._database.connection() as connection:
                yield connection
        except TimeoutError:
            raise StoreUnreachable(f"{self._database.name} did not answer within {self._seconds:.2g} s") from None
