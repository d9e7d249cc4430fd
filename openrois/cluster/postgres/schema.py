"""The schema of the store by version: made and migrated forward when a gateway starts, and back by one version.

Gateways of two versions share a store while they are upgraded one by one: a version adds to what the one before it
reads and writes, and changes none of that. Such a program therefore starts at a schema that is newer by one version,
and leaves it as it is. What the older one does not write may be missing: a column that is added can be NULL, or has a
default. What a version needs no more goes with the version after it.
"""

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from asyncpg import Connection

__all__ = ["NEWEST", "STEPS", "VERSION", "Step", "StoreUnusable", "migrate", "migrate_back"]

_LOCK: Final = 0x526F4953
"""Of gateways that start at once, the one with this advisory lock migrates."""

_PATIENCE: Final = 60.0
"""Seconds that a migration may take, with the wait for another gateway's."""


class StoreUnusable(Exception):
    """The database cannot be the store of these gateways; the text says why, in one line."""


@dataclass(frozen=True, slots=True)
class Step:
    """Statements between two versions of the schema.

    Attributes:
        forward: make of the version before it this one.
        back: undo that; what the older version does not know is lost.
    """

    forward: str
    back: str


STEPS: Final = (
    Step(
        forward="""
            CREATE TABLE openrois.gateway (
                gateway_id text PRIMARY KEY, run bigint NOT NULL, expires_ms bigint NOT NULL, ttl_ms bigint NOT NULL
            ) WITH (fillfactor = 50);
            CREATE TABLE openrois.claim (
                engine_id text PRIMARY KEY, gateway_id text NOT NULL, instance text NOT NULL,
                first_epoch bigint NOT NULL
            ) WITH (fillfactor = 80);
            CREATE FUNCTION openrois.notify_owner() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN
                PERFORM pg_notify('openrois', 'owner ' || coalesce(NEW.engine_id, OLD.engine_id));
                RETURN NULL;
            END $$;
            CREATE TRIGGER notify_owner AFTER INSERT OR UPDATE OR DELETE ON openrois.claim
                FOR EACH ROW EXECUTE FUNCTION openrois.notify_owner();
        """,
        back="DROP TABLE openrois.claim; DROP FUNCTION openrois.notify_owner; DROP TABLE openrois.gateway;",
    ),
    Step(
        forward="""
            CREATE TABLE openrois.resume_line (
                line_id text PRIMARY KEY, subject text NOT NULL, generation bigint NOT NULL, good bytea,
                is_revoked boolean NOT NULL DEFAULT false, touched_ms bigint NOT NULL
            );
            CREATE INDEX resume_line_by_touch ON openrois.resume_line (touched_ms);
            CREATE TABLE openrois.resume_token (
                digest bytea PRIMARY KEY, number bigint GENERATED ALWAYS AS IDENTITY,
                line_id text NOT NULL REFERENCES openrois.resume_line ON DELETE CASCADE
            );
            CREATE INDEX resume_token_by_line ON openrois.resume_token (line_id, number);
            CREATE TABLE openrois.holding (
                component_ref text PRIMARY KEY, engine_id text NOT NULL, line_id text NOT NULL,
                epoch bigint NOT NULL, touched_ms bigint NOT NULL
            );
            CREATE INDEX holding_by_engine ON openrois.holding (engine_id);
            CREATE INDEX holding_by_line ON openrois.holding (line_id);
            CREATE INDEX holding_by_touch ON openrois.holding (touched_ms);
        """,
        back="DROP TABLE openrois.holding; DROP TABLE openrois.resume_token; DROP TABLE openrois.resume_line;",
    ),
    Step(
        forward="""
            CREATE TABLE openrois.command (
                gateway_id text NOT NULL, run bigint NOT NULL, number bigint NOT NULL, session text NOT NULL,
                command_key bytea NOT NULL, subject_key bytea NOT NULL, component_ref text NOT NULL,
                accepted_ms bigint NOT NULL, status text, reason text NOT NULL DEFAULT '', results text,
                is_told boolean NOT NULL DEFAULT false,
                PRIMARY KEY (gateway_id, run, number), UNIQUE (gateway_id, run, session, command_key)
            );
            CREATE INDEX command_by_subject ON openrois.command (subject_key, command_key);
            CREATE INDEX command_by_age ON openrois.command (accepted_ms);
        """,
        back="DROP TABLE openrois.command;",
    ),
    Step(
        forward="ALTER TABLE openrois.resume_line ADD COLUMN rank text NOT NULL DEFAULT '';",
        back="ALTER TABLE openrois.resume_line DROP COLUMN rank;",
    ),
)
"""What leads from each version to the next; version 0 is an empty schema."""

VERSION: Final = len(STEPS)
"""The version of the schema that this program makes."""

NEWEST: Final = VERSION + 1
"""The newest version of the schema that this program reads and writes: it is made for this one, too."""


async def migrate(connection: "Connection", steps: Sequence[Step] = STEPS) -> int:
    """Make the schema, or carry it over to the present version, all or nothing; return the version that it had.

    One that is newer by one version stays as it is.

    Raises:
        StoreUnusable: the schema is newer than that.
    """
    async with _found_version(connection) as found:
        if found > len(steps) + 1:
            raise StoreUnusable(
                f"the store has version {found} of the schema, and this program works with versions up to "
                f"{len(steps) + 1}: install a newer one, or run `openrois gateway --migrate-store-back` of the newest"
            )
        await _go(connection, steps, found, max(found, len(steps)))
    return found


async def migrate_back(connection: "Connection", steps: Sequence[Step] = STEPS) -> int:
    """Carry the schema back to the version before the present one; return the version that it had.

    No gateway that knows the present version may run; those of the version before go on.

    Raises:
        StoreUnusable: the schema has another version than the present one.
    """
    async with _found_version(connection) as found:
        if found != len(steps):
            raise StoreUnusable(
                f"the store has version {found} of the schema, and this program goes back from version {len(steps)}: "
                "run the OpenRoIS that made it"
            )
        await _go(connection, steps, found, found - 1)
    return found


@asynccontextmanager
async def _found_version(connection: "Connection") -> AsyncIterator[int]:
    """Yield the version of the schema, which changes within the block alone."""
    async with connection.transaction():
        await connection.execute(f"SET LOCAL lock_timeout = {_PATIENCE * 1000:.0f}; SET LOCAL statement_timeout = 0")
        await connection.execute("SELECT pg_advisory_xact_lock($1)", _LOCK, timeout=_PATIENCE)
        yield await _version(connection)


async def _go(connection: "Connection", steps: Sequence[Step], found: int, version: int) -> None:
    for number in range(found, version):
        await connection.execute(steps[number].forward, timeout=_PATIENCE)
    for number in range(found, version, -1):
        await connection.execute(steps[number - 1].back, timeout=_PATIENCE)
    if found != version:
        await connection.execute("UPDATE openrois.version SET version = $1", version)


async def _version(connection: "Connection") -> int:
    """Return the version of the schema; one that is missing is made."""
    if await connection.fetchval("SELECT to_regclass('openrois.version') IS NULL"):
        await connection.execute(
            "CREATE SCHEMA IF NOT EXISTS openrois; CREATE TABLE openrois.version (version integer NOT NULL); "
            "INSERT INTO openrois.version VALUES (0)"
        )
    return int(await connection.fetchval("SELECT version FROM openrois.version"))
