"""Ownership in PostgreSQL: each step is one statement, and the server's clock alone judges time-outs."""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Final

from openrois.cluster.postgres.database import NOW, Database
from openrois.ownership.claims import Owner
from openrois.ownership.rules import Reading, Record
from openrois.ownership.store import Digest, Hint, Renewed

if TYPE_CHECKING:
    from asyncpg import Connection

__all__ = ["PostgresStore"]

_TOPIC: Final = "owner"
_FORGOTTEN: Final = 86_400_000
"""Milliseconds after which what is left of a gateway that does not renew is removed."""

_REGISTER: Final = """
    WITH clock AS MATERIALIZED (SELECT {now} AS now),
    released AS (UPDATE openrois.claim SET gateway_id = '', instance = '' WHERE gateway_id = $1)
    INSERT INTO openrois.gateway AS former (gateway_id, run, expires_ms, ttl_ms)
    SELECT $1::text, now, now + $2::bigint, $2::bigint FROM clock
    ON CONFLICT (gateway_id) DO UPDATE
    SET run = greatest(former.run + 1, excluded.run), expires_ms = excluded.expires_ms, ttl_ms = excluded.ttl_ms
    RETURNING run, expires_ms - ttl_ms AS now
"""
_RENEW: Final = """
    WITH clock AS MATERIALIZED (SELECT {now} AS now),
    former AS MATERIALIZED (SELECT expires_ms FROM openrois.gateway WHERE gateway_id = $1)
    INSERT INTO openrois.gateway AS known (gateway_id, run, expires_ms, ttl_ms)
    SELECT $1::text, $2::bigint, now + $3::bigint, $3::bigint FROM clock
    ON CONFLICT (gateway_id) DO UPDATE
    SET run = excluded.run, expires_ms = excluded.expires_ms, ttl_ms = excluded.ttl_ms WHERE known.run <= excluded.run
    RETURNING run, coalesce((SELECT expires_ms FROM former), 0) AS former, expires_ms - ttl_ms AS now
"""
# The clock was stepped back: what has expired would hold for as long as that.
_SHORTEN: Final = """
    UPDATE openrois.gateway SET expires_ms = $1 + ttl_ms WHERE gateway_id IN (
        SELECT gateway_id FROM openrois.gateway WHERE expires_ms > $1 + ttl_ms + 1000 FOR UPDATE SKIP LOCKED
    )
"""
_DIGEST: Final = """
    SELECT gateway_id, count(*), sum(first_epoch)::bigint FROM openrois.claim WHERE gateway_id <> '' GROUP BY gateway_id
"""
_READ: Final = """
    SELECT claim.gateway_id, claim.instance, claim.first_epoch,
        coalesce(owner.expires_ms, 0) AS expires_ms, coalesce(owner.ttl_ms, 0) AS ttl_ms,
        coalesce(own.run, 0) AS run, coalesce(own.expires_ms, 0) AS own_expires_ms, {now} AS now
    FROM (VALUES ($1::text)) AS asked (engine_id)
    LEFT JOIN openrois.claim USING (engine_id)
    LEFT JOIN openrois.gateway AS owner ON owner.gateway_id = claim.gateway_id
    LEFT JOIN openrois.gateway AS own ON own.gateway_id = $2
"""
# The row of an owner that has expired is locked until this is written: it renews before that, or loses.
_WRITE: Final = """
    WITH expired AS MATERIALIZED (
        SELECT 1 FROM openrois.gateway WHERE gateway_id = $7 AND expires_ms = $8 FOR SHARE
    )
    INSERT INTO openrois.claim AS known (engine_id, gateway_id, instance, first_epoch)
    SELECT $1::text, $2::text, $3::text, $4::bigint
    WHERE EXISTS (SELECT FROM openrois.gateway WHERE gateway_id = $2 AND run = $5)
        AND ($8::bigint IS NULL OR EXISTS (SELECT FROM expired))
        AND ($6::bigint < 0 OR EXISTS (SELECT FROM openrois.claim WHERE engine_id = $1))
    ON CONFLICT (engine_id) DO UPDATE
    SET gateway_id = excluded.gateway_id, instance = excluded.instance, first_epoch = excluded.first_epoch
    WHERE known.first_epoch = $6 AND known.gateway_id = $7
    RETURNING true
"""
_RELEASE: Final = """
    UPDATE openrois.claim SET gateway_id = '', instance = ''
    WHERE gateway_id = $1 AND ($3::text IS NULL OR engine_id = $3 AND first_epoch = $4)
        AND EXISTS (SELECT FROM openrois.gateway WHERE gateway_id = $1 AND run = $2)
"""
_OWNERS: Final = """
    SELECT engine_id, gateway_id, instance, first_epoch FROM openrois.claim
    WHERE gateway_id <> '' AND ($1::text[] IS NULL OR engine_id = ANY($1))
"""
# Epochs begin behind the clock: what was reserved that long ago need not be kept.
_FORGET: Final = """
    WITH gone AS (DELETE FROM openrois.gateway WHERE expires_ms < $1 AND gateway_id <> $2)
    DELETE FROM openrois.claim WHERE first_epoch < $1 AND NOT EXISTS (
        SELECT FROM openrois.gateway WHERE gateway_id = claim.gateway_id AND expires_ms >= $1
    )
"""


class PostgresStore:
    """An `OwnershipStore` in a database that gateways share.

    Args:
        database: it is entered by the caller.
        now: the SQL of epoch milliseconds, as one bigint.
    """

    def __init__(self, database: Database, *, now: str = NOW) -> None:
        self.name = database.name
        self._database = database
        self._register = _REGISTER.format(now=now)
        self._renew = _RENEW.format(now=now)
        self._read = _READ.format(now=now)

    async def register(self, gateway_id: str, ttl_ms: int) -> Renewed:
        """Begin as a gateway; what is left of gateways that ended long ago is removed."""
        async with self._database.link() as link:
            row = await link.fetchrow(self._register, gateway_id, ttl_ms)
            await link.execute(_FORGET, row["now"] - _FORGOTTEN, gateway_id)
            return Renewed(row["run"], 0, row["now"], await _digest(link))

    async def renew(self, gateway_id: str, run: int, ttl_ms: int) -> Renewed | None:
        """Prolong all claims of a gateway."""
        async with self._database.link() as link:
            row = await link.fetchrow(self._renew, gateway_id, run, ttl_ms)
            if row is None:
                return None
            await link.execute(_SHORTEN, row["now"])
            return Renewed(row["run"], row["former"], row["now"], await _digest(link))

    async def read(self, engine_id: str, gateway_id: str) -> Reading:
        """Return what a gateway has to know to claim an engine."""
        async with self._database.connection() as connection:
            row = await connection.fetchrow(self._read, engine_id, gateway_id)
        known = row["first_epoch"] is not None
        record = Record(engine_id, row["gateway_id"], row["instance"], row["first_epoch"]) if known else None
        return Reading(record, *row[3:])

    async def write(self, record: Record, run: int, seen: Record | None, expired_ms: int | None) -> bool:
        """Write a claim if nothing has changed since it was read."""
        claim = (record.engine_id, record.gateway_id, record.instance, record.first_epoch, run)
        former = (-1, "") if seen is None else (seen.first_epoch, seen.gateway_id)
        async with self._database.connection() as connection:
            return bool(await connection.fetchval(_WRITE, *claim, *former, expired_ms))

    async def release(self, record: Record, run: int) -> None:
        """Release an engine."""
        async with self._database.connection() as connection:
            await connection.execute(_RELEASE, record.gateway_id, run, record.engine_id, record.first_epoch)

    async def leave(self, gateway_id: str, run: int) -> None:
        """Release all engines of a gateway."""
        async with self._database.connection() as connection:
            await connection.execute(_RELEASE, gateway_id, run, None, None)

    async def owners(self, engine_ids: Iterable[str] | None) -> list[Owner]:
        """Return owners."""
        wanted = None if engine_ids is None else list(engine_ids)
        async with self._database.connection() as connection:
            rows = await connection.fetch(_OWNERS, wanted)
        return [Owner(*row) for row in rows]

    def listen(self, hint: Hint) -> Callable[[], None]:
        """Call `hint` when a notification comes, and when some may have been missed."""
        return self._database.listen(_TOPIC, lambda engine_id: hint(None if engine_id is None else (engine_id,)))


async def _digest(link: "Connection") -> Digest:
    return {gateway_id: (engines, epochs) for gateway_id, engines, epochs in await link.fetch(_DIGEST)}
