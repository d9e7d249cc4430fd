"""A look at PostgreSQL from outside: whether it can be the store of gateways, and what these have there."""

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from openrois.cluster.postgres.database import NOW, Database
from openrois.cluster.postgres.schema import NEWEST, VERSION

if TYPE_CHECKING:
    from asyncpg import Connection

__all__ = ["NEWEST", "VERSION", "KnownGateway", "StoreFacts", "examine_store"]

_SETTINGS: Final = """
    SELECT current_setting('server_version') AS version, current_setting('server_version_num')::int AS number,
        pg_is_in_recovery() AS is_standby, current_setting('transaction_read_only') = 'on' AS is_read_only,
        current_setting('fsync') = 'on' AS fsync, current_setting('full_page_writes') = 'on' AS full_page_writes,
        current_setting('synchronous_commit') AS synchronous_commit,
        current_setting('max_connections')::int - current_setting('superuser_reserved_connections')::int
            - (SELECT count(*) FROM pg_stat_activity WHERE backend_type = 'client backend') AS free_connections,
        to_regclass('openrois.version') IS NOT NULL AS has_schema, current_user AS user_name
"""
_MAY_MAKE: Final = "SELECT has_database_privilege(current_database(), 'CREATE')"
_MAY_WRITE: Final = """
    SELECT coalesce(bool_and(has_table_privilege(oid, 'SELECT') AND has_table_privilege(oid, 'INSERT')
        AND has_table_privilege(oid, 'UPDATE') AND has_table_privilege(oid, 'DELETE')), true)
    FROM pg_class WHERE relnamespace = 'openrois'::regnamespace AND relkind = 'r'
"""
_GATEWAYS: Final = """
    SELECT gateway_id, expires_ms > $1 AS holds,
        ARRAY(SELECT engine_id FROM openrois.claim WHERE gateway_id = known.gateway_id ORDER BY engine_id) AS engine_ids
    FROM openrois.gateway AS known ORDER BY gateway_id
"""


@dataclass(frozen=True, slots=True)
class KnownGateway:
    """A gateway as the store has it.

    Attributes:
        gateway_id: its id.
        holds: whether its claims hold now: it runs, or ended moments ago.
        engine_ids: the engines that it owns, or had when it ended.
    """

    gateway_id: str
    holds: bool
    engine_ids: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class StoreFacts:
    """What a server and a database of PostgreSQL are.

    Attributes:
        name: of hosts and database, for sentences.
        version: of the server, as it says.
        number: the same as PostgreSQL counts it: 150004 is 15.4.
        user_name: the user that a gateway is there.
        is_standby: whether it follows another server.
        is_read_only: whether it takes no changes.
        fsync: whether it waits for the disk.
        full_page_writes: whether pages that were half written are mended.
        synchronous_commit: the setting as a gateway's connections have it.
        free_connections: connections that may be made besides.
        schema_version: of the tables; None where there are none yet.
        may_write: whether the user may make the tables, or change them.
        round_trip: seconds of one question.
        ahead: seconds by which the server's clock is ahead of this machine's, give or take half the round trip.
        gateways: those that it knows; none where the schema is missing, or newer than this program can read.
    """

    name: str
    version: str
    number: int
    user_name: str
    is_standby: bool
    is_read_only: bool
    fsync: bool
    full_page_writes: bool
    synchronous_commit: str
    free_connections: int
    schema_version: int | None
    may_write: bool
    round_trip: float
    ahead: float
    gateways: tuple[KnownGateway, ...]


async def examine_store(database: Database) -> StoreFacts:
    """Look at a database that is not entered, and change nothing.

    Raises:
        StoreUnreachable: the database is not there, or refuses.
    """
    async with database.connection() as connection:
        try:
            return await _facts(connection, database.name)
        finally:
            await connection.close(timeout=1.0)


async def _facts(connection: "Connection", name: str) -> StoreFacts:
    found: dict[str, Any] = dict(await connection.fetchrow(_SETTINGS))
    has_schema = found.pop("has_schema")
    schema_version: int | None = None
    gateways: tuple[KnownGateway, ...] = ()
    before, began = time.time(), time.perf_counter()
    now_ms = await connection.fetchval(f"SELECT {NOW}")
    round_trip = time.perf_counter() - began
    may_write = bool(await connection.fetchval(_MAY_MAKE))
    if has_schema:
        schema_version = int(await connection.fetchval("SELECT version FROM openrois.version"))
        may_write = bool(await connection.fetchval(_MAY_WRITE))
        if 0 < schema_version <= NEWEST:
            rows = await connection.fetch(_GATEWAYS, now_ms)
            gateways = tuple(KnownGateway(row[0], row[1], tuple(row[2])) for row in rows)
    return StoreFacts(
        name=name,
        **found,
        schema_version=schema_version,
        may_write=may_write,
        round_trip=round_trip,
        ahead=now_ms / 1000 - before - round_trip / 2,
        gateways=gateways,
    )
