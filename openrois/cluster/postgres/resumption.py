"""Lines and holdings in PostgreSQL: each step is one statement, and rows are locked in one order."""

from collections.abc import Iterable
from typing import Final

from openrois.cluster.postgres.calls import CALL_TIME, Calls
from openrois.cluster.postgres.database import NOW, Database
from openrois.journal.records import storable
from openrois.resumption.lines import MAX_SPENT, Change, Held, Holding, Redemption, last_changes
from openrois.resumption.store import KEPT_FOR, MAX_PRUNED

__all__ = ["PostgresResumeStore"]

_AT_ONCE: Final = 3
"""Calls that are under way at once."""

# A digest that is known already is no new one: it is the good one still, or was used.
_ISSUE: Final = """
    WITH line AS (
        INSERT INTO openrois.resume_line AS known (line_id, subject, generation, good, rank, touched_ms)
        SELECT $1::text, $3::text, $2::bigint, $4::bytea, $5::text, {now}
        WHERE NOT EXISTS (SELECT FROM openrois.resume_token WHERE digest = $4)
        ON CONFLICT (line_id) DO UPDATE
        SET subject = excluded.subject, generation = excluded.generation, good = excluded.good,
            rank = excluded.rank, touched_ms = excluded.touched_ms
        WHERE NOT known.is_revoked AND known.generation <= excluded.generation
        RETURNING line_id
    ),
    token AS (INSERT INTO openrois.resume_token (digest, line_id) SELECT $4, line_id FROM line),
    forgotten AS (
        DELETE FROM openrois.resume_token WHERE line_id = $1 AND number <= (
            SELECT number FROM openrois.resume_token WHERE line_id = $1 ORDER BY number DESC LIMIT 1 OFFSET {most_spent}
        )
    )
    SELECT EXISTS (SELECT FROM line) OR EXISTS (
        SELECT FROM openrois.resume_line WHERE line_id = $1 AND good = $4 AND generation <= $2
    )
"""
# What was freed keeps its epoch, so that what comes late changes nothing.
_FREE: Final = """
    held AS MATERIALIZED (
        SELECT component_ref FROM openrois.holding WHERE line_id IN (SELECT line_id FROM over)
        ORDER BY component_ref FOR UPDATE
    ),
    freed AS (
        UPDATE openrois.holding SET engine_id = '', line_id = '', touched_ms = {now}
        FROM held WHERE holding.component_ref = held.component_ref
    )
"""
_REDEEM: Final = """
    WITH line AS (
        UPDATE openrois.resume_line
        SET generation = CASE WHEN good = $1 THEN generation + 1 ELSE generation END,
            is_revoked = good IS DISTINCT FROM $1, good = NULL, touched_ms = {now}
        WHERE line_id = (SELECT line_id FROM openrois.resume_token WHERE digest = $1::bytea) AND subject = $2::text
        RETURNING line_id, generation, is_revoked
    ),
    over AS (SELECT line_id FROM line WHERE is_revoked),
    {free}
    SELECT line_id, generation, is_revoked FROM line
"""
_TOUCH: Final = """
    WITH known AS MATERIALIZED (
        SELECT line_id FROM openrois.resume_line WHERE line_id = ANY($1::text[]) ORDER BY line_id FOR UPDATE
    )
    UPDATE openrois.resume_line AS line SET touched_ms = {now} FROM known WHERE line.line_id = known.line_id
"""
_END: Final = """
    WITH over AS (DELETE FROM openrois.resume_line WHERE line_id = $1 AND generation <= $2 RETURNING line_id),
    {free}
    SELECT
"""
_PRUNE_LINES: Final = """
    WITH over AS MATERIALIZED (
        SELECT line_id FROM openrois.resume_line WHERE touched_ms < {now} - {kept_ms}
        ORDER BY touched_ms LIMIT {most_pruned} FOR UPDATE SKIP LOCKED
    )
    DELETE FROM openrois.resume_line AS line USING over WHERE line.line_id = over.line_id
"""
_WRITE: Final = """
    INSERT INTO openrois.holding AS known (component_ref, engine_id, line_id, epoch, touched_ms)
    SELECT component_ref, engine_id, line_id, epoch, {now}
    FROM unnest($1::text[], $2::text[], $3::text[], $4::bigint[]) AS changed (component_ref, engine_id, line_id, epoch)
    ORDER BY component_ref
    ON CONFLICT (component_ref) DO UPDATE
    SET engine_id = excluded.engine_id, line_id = excluded.line_id, epoch = excluded.epoch,
        touched_ms = excluded.touched_ms
    WHERE known.epoch <= excluded.epoch
"""
# What a line that is there holds is looked at again as late as what has just been written.
_PRUNE_HOLDINGS: Final = """
    WITH old AS MATERIALIZED (
        SELECT component_ref, EXISTS (SELECT FROM openrois.resume_line AS line WHERE line.line_id = holding.line_id)
            AS is_held
        FROM openrois.holding WHERE touched_ms < {now} - {kept_ms}
        ORDER BY touched_ms LIMIT {most_pruned} FOR UPDATE SKIP LOCKED
    ),
    gone AS (
        DELETE FROM openrois.holding USING old WHERE holding.component_ref = old.component_ref AND NOT is_held
    )
    UPDATE openrois.holding SET touched_ms = {now} FROM old
    WHERE holding.component_ref = old.component_ref AND is_held
"""
_HELD: Final = """
    SELECT component_ref, engine_id, line_id, epoch, subject, rank
    FROM openrois.holding JOIN openrois.resume_line USING (line_id)
    WHERE engine_id = ANY($1::text[]) AND NOT is_revoked ORDER BY component_ref
"""


class PostgresResumeStore:
    """A `ResumeStore` in a database that gateways share.

    Args:
        database: it is entered by the caller.
        patience: seconds in which each call has its result or its error.
        now: the SQL of epoch milliseconds, as one bigint.
    """

    def __init__(self, database: Database, *, patience: float = CALL_TIME, now: str = NOW) -> None:
        self.name = database.name
        self._calls = Calls(database, _AT_ONCE, patience)
        words = {
            "now": now,
            "free": _FREE.format(now=now),
            "kept_ms": f"{KEPT_FOR * 1000:.0f}",
            "most_spent": MAX_SPENT,
            "most_pruned": MAX_PRUNED,
        }
        self._issue = _ISSUE.format(**words)
        self._redeem = _REDEEM.format(**words)
        self._touch = _TOUCH.format(**words)
        self._end = _END.format(**words)
        self._write = _WRITE.format(**words)
        self._prune_lines = _PRUNE_LINES.format(**words)
        self._prune_holdings = _PRUNE_HOLDINGS.format(**words)

    async def issue(self, line_id: str, generation: int, subject: str, digest: bytes, *, rank: str = "") -> bool:
        """Make a digest the good one of a line; some lines that were not touched for long are removed."""
        async with self._calls.connection() as connection:
            asked = (line_id, generation, storable(subject), digest, storable(rank))
            is_good = await connection.fetchval(self._issue, *asked)
            await connection.execute(self._prune_lines)
        return bool(is_good)

    async def redeem(self, digest: bytes, subject: str) -> Redemption:
        """Use up a token."""
        async with self._calls.connection() as connection:
            row = await connection.fetchrow(self._redeem, digest, storable(subject))
        return Redemption() if row is None else Redemption(*row)

    async def touch(self, line_ids: Iterable[str]) -> None:
        """Keep lines for another while."""
        async with self._calls.connection() as connection:
            await connection.execute(self._touch, list(line_ids))

    async def end_line(self, line_id: str, generation: int) -> None:
        """Remove a line."""
        async with self._calls.connection() as connection:
            await connection.execute(self._end, line_id, generation)

    async def write(self, changes: Iterable[Change]) -> None:
        """Write which components are held and freed; some that were freed long ago are removed."""
        rows = [
            (change.component_ref, change.engine_id, change.line_id, change.epoch)
            if isinstance(change, Held)
            else (change.component_ref, "", "", change.epoch)
            for change in last_changes(changes).values()
        ]
        if not rows:
            return
        async with self._calls.connection() as connection:
            await connection.execute(self._write, *map(list, zip(*rows, strict=True)))
            await connection.execute(self._prune_holdings)

    async def held(self, engine_ids: Iterable[str]) -> tuple[Holding, ...]:
        """Return which components of these engines are held."""
        async with self._calls.connection() as connection:
            rows = await connection.fetch(_HELD, list(engine_ids))
        return tuple(Holding(*row) for row in rows)
