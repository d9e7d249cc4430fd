"""The schema of the store by version: made and migrated forward when a gateway starts, and back by one version.

Gateways of two versions share a store while they are upgraded one by one: a version adds to what the one before it
reads and writes, and changes none of that.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from asyncpg import Connection

__all__ = ["STEPS", "VERSION", "Step", "StoreUnusable", "migrate", "migrate_back"]

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
)
"""What leads from each version to the next; version 0 is an empty schema."""

VERSION: Final = len(STEPS)
"""The version of the schema that this program reads and writes."""


async def migrate(connection: "Connection", steps: Sequence[Step] = STEPS) -> int:
    """Make the schema, or carry it over to the present version, all or nothing; return the version that it had.

    Raises:
        StoreUnusable: the schema is newer than this program knows.
    """
    return await _go(connection, steps, len(steps))


async def migrate_back(connection: "Connection", steps: Sequence[Step] = STEPS) -> int:
    """Carry the schema back to the version before the present one, for gateways of that version to start with.

    No gateway of the present version may run.

    Raises:
        StoreUnusable: the schema is newer than this program knows.
    """
    return await _go(connection, steps, len(steps) - 1)


async def _go(connection: "Connection", steps: Sequence[Step], version: int) -> int:
    async with connection.transaction():
        await connection.execute(f"SET LOCAL lock_timeout = {_PATIENCE * 1000:.0f}; SET LOCAL statement_timeout = 0")
        await connection.execute("SELECT pg_advisory_xact_lock($1)", _LOCK, timeout=_PATIENCE)
        found = await _version(connection)
        if found > len(steps):
            raise StoreUnusable(
                f"the store has version {found} of the schema, and this program knows versions up to {len(steps)}: "
                "install a newer one, or have the newer one migrate the store back"
            )
        for number in range(found, version):
            await connection.execute(steps[number].forward, timeout=_PATIENCE)
        for number in range(found, version, -1):
            await connection.execute(steps[number - 1].back, timeout=_PATIENCE)
        if found != version:
            await connection.execute("UPDATE openrois.version SET version = $1", version)
    return found


async def _version(connection: "Connection") -> int:
    """Return the version of the schema; one that is missing is made."""
    if await connection.fetchval("SELECT to_regclass('openrois.version') IS NULL"):
        await connection.execute(
            "CREATE SCHEMA IF NOT EXISTS openrois; CREATE TABLE openrois.version (version integer NOT NULL); "
            "INSERT INTO openrois.version VALUES (0)"
        )
    return int(await connection.fetchval("SELECT version FROM openrois.version"))
