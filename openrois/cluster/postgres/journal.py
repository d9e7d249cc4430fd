"""A journal in PostgreSQL: records are written behind, and each gateway tells how the commands of others ended."""

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable, Mapping
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from hashlib import sha256
from itertools import count, islice
from types import TracebackType
from typing import TYPE_CHECKING, Final, Self

from openrois.aio.write_loop import WriteLoop
from openrois.cluster.postgres.calls import CALL_TIME, Calls
from openrois.cluster.postgres.database import NOW, Database
from openrois.errors import StoreUnreachable
from openrois.journal.former import GATEWAY_LOST, FormerCommand
from openrois.journal.journal import MAX_WAITING, PATIENCE
from openrois.journal.records import KEPT_FOR, MAX_ENDED, Accepted, Ended, read_results, storable, written_results
from openrois.ownership.rules import TTL
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result

if TYPE_CHECKING:
    from asyncpg import Connection, Record

__all__ = ["PostgresJournal"]

_log = logging.getLogger(__name__)

_BATCH: Final = 1024
_PRUNE_AFTER: Final = 1024
_CLOSING: Final = 5.0
_INTERRUPTED: Final = "INTERRUPTED"

# A batch that was written although its answer was lost is written again: then the number is not greater.
_ACCEPTED: Final = """
    INSERT INTO openrois.command AS known
        (gateway_id, run, number, session, command_key, subject_key, component_ref, accepted_ms)
    SELECT $1::text, $2::bigint, number, session, command_key, subject_key, component_ref, {now}
    FROM unnest($3::bigint[], $4::text[], $5::bytea[], $6::bytea[], $7::text[])
        AS given (number, session, command_key, subject_key, component_ref)
    ON CONFLICT (gateway_id, run, session, command_key) DO UPDATE
    SET number = excluded.number, subject_key = excluded.subject_key, component_ref = excluded.component_ref,
        accepted_ms = excluded.accepted_ms, status = NULL, reason = '', results = NULL, is_told = false
    WHERE known.number < excluded.number
"""
# One that was told as lost has had its end.
_ENDED: Final = """
    UPDATE openrois.command AS known SET status = given.status, reason = given.reason, results = given.results
    FROM unnest($3::text[], $4::bytea[], $5::text[], $6::text[], $7::text[])
        AS given (session, command_key, status, reason, results)
    WHERE known.gateway_id = $1::text AND known.run = $2::bigint AND known.session = given.session
        AND known.command_key = given.command_key AND known.status IS NULL
"""
# A gateway that could not renew, because the store was away, is not taken for dead before it had the time to. What it
# ran at an engine that another gateway owns by now is lost, whether it is dead or not: the adapter has left it.
_FOUND: Final = """
    found AS MATERIALIZED (
        SELECT command.gateway_id, command.run, number, status IS NULL AND CASE WHEN owner.run IS NULL
            THEN {ttl_ms} > $5::bigint
            ELSE owner.run <= command.run AND (owner.expires_ms > {now} OR owner.ttl_ms > $5)
            END AND NOT EXISTS (
                SELECT FROM openrois.claim WHERE engine_id = split_part(component_ref, '/', 1)
                AND claim.gateway_id NOT IN ('', command.gateway_id)
            ) AS is_running
        FROM openrois.command LEFT JOIN openrois.gateway AS owner USING (gateway_id)
        WHERE subject_key = $1::bytea AND command_key = $2::bytea
            AND NOT (gateway_id = $3::text AND command.run = $4::bigint)
        ORDER BY accepted_ms DESC, number DESC LIMIT 1
    )
"""
_FIND: Final = """
    WITH {found}
    SELECT component_ref, status, reason, results, is_told, is_running
    FROM found JOIN openrois.command USING (gateway_id, run, number)
"""
_DELIVER: Final = """
    WITH {found}
    UPDATE openrois.command AS known SET is_told = true, status = coalesce(status, '{interrupted}')
    FROM found WHERE (known.gateway_id, known.run, known.number) = (found.gateway_id, found.run, found.number)
        AND NOT is_told AND NOT is_running
    RETURNING component_ref, status, reason, results, is_told, is_running
"""
_PRUNE: Final = """
    DELETE FROM openrois.command WHERE gateway_id = $1 AND (status IS NOT NULL OR run <> $2) AND (run, number) <= (
        SELECT run, number FROM openrois.command WHERE gateway_id = $1 AND (status IS NOT NULL OR run <> $2)
        ORDER BY run DESC, number DESC LIMIT 1 OFFSET $3
    )
"""
_FORGET: Final = """
    DELETE FROM openrois.command WHERE (gateway_id, run, number) IN (
        SELECT gateway_id, run, number FROM openrois.command WHERE accepted_ms < {now} - {kept_ms}
        ORDER BY accepted_ms LIMIT {most} FOR UPDATE SKIP LOCKED
    )
"""


@dataclass(frozen=True, slots=True)
class _Waiting:
    """A record, its number, and what waits until it is written."""

    number: int
    record: Accepted | Ended
    done: asyncio.Future[None] | None


class PostgresJournal(AbstractAsyncContextManager["PostgresJournal"]):
    """A `Journal` in a database that gateways share. Enter it as long as the gateway runs.

    Each command belongs to the run of a gateway. One without an end whose run is over, because the gateway does not
    renew its claims or was started again, has ended with ERROR; one whose gateway is there still runs.

    Which engines were there says ownership: none is expected back at this gateway.

    Args:
        database: it is entered by the caller.
        gateway_id: of this gateway.
        run: the number of its process, as ownership registered it.
        contact: seconds for which this gateway has been in contact with the store without a break.
        patience: seconds that a command waits to be written before it is accepted.
        seconds: in which each call to the store has its result or its error.
        sleep: waits for some seconds.
        most: records that may wait.
        now: the SQL of epoch milliseconds, as one bigint.
    """

    def __init__(
        self,
        database: Database,
        gateway_id: str,
        run: int,
        contact: Callable[[], float],
        *,
        patience: float = PATIENCE,
        seconds: float = CALL_TIME,
        sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
        most: int = MAX_WAITING,
        now: str = NOW,
    ) -> None:
        self.lost = 0
        self.failures = 0
        self.failing = False
        self.written = 0
        self.late = 0
        self.engines: frozenset[str] = frozenset()
        self._name = database.name
        self._of_run = gateway_id, run
        self._contact = contact
        self._patience = patience
        self._most = most
        # What is asked does not delay what is written.
        self._writing = Calls(database, 1, seconds)
        self._asking = Calls(database, 1, seconds)
        found = _FOUND.format(now=now, ttl_ms=round(TTL * 1000))
        self._find = _FIND.format(found=found)
        self._deliver = _DELIVER.format(found=found, interrupted=_INTERRUPTED)
        self._accepted = _ACCEPTED.format(now=now)
        self._forget = _FORGET.format(now=now, kept_ms=round(KEPT_FOR * 1000), most=_PRUNE_AFTER)
        self._unpruned = _PRUNE_AFTER
        self._numbers = count(1)
        self._queue: deque[_Waiting] = deque()
        self._loop = WriteLoop(lambda: bool(self._queue), self._write, sleep)

    async def __aenter__(self) -> Self:
        await self._loop.__aenter__()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Write what waits, for at most some seconds."""
        try:
            if not await self._loop.flushed(_CLOSING):
                self.lost += len(self._queue)
                _log.error("the journal in %s ends without %d records", self._name, len(self._queue))
        finally:
            await self._loop.__aexit__(kind, error, trace)

    @property
    def waiting(self) -> int:
        """Number of records that wait to be written."""
        return len(self._queue)

    async def accepted(self, session: str, subject: str, commands: Mapping[str, str]) -> None:
        """Note commands that are about to be accepted; returns when they are written, or a moment later."""
        last = None if self.failing else asyncio.get_running_loop().create_future()
        left = len(commands)
        for command_id, component_ref in commands.items():
            left -= 1
            record = Accepted(session, command_id, subject, component_ref, 0.0)
            self._put(record, None if left else last)
        if last is not None:
            done, _ = await asyncio.wait((last,), timeout=self._patience)
            if not done:
                self.late += 1

    def ended(
        self, session: str, command_id: str, status: CompletedStatus, reason: str, results: tuple[Result, ...]
    ) -> None:
        """Note that a command has ended."""
        self._put(Ended(session, command_id, status, reason, results))

    def engine(self, engine_id: str, *, is_there: bool) -> None:
        """Do nothing: ownership knows which engines are attached, and to which gateway."""

    async def find(self, subject: str, command_id: str) -> FormerCommand | None:
        """Return a command that another run accepted."""
        return await self._ask(self._find, subject, command_id)

    async def deliver_outcome(self, subject: str, command_id: str) -> FormerCommand | None:
        """Return a command of another run whose end was not notified yet, and note that it is from now on."""
        return await self._ask(self._deliver, subject, command_id)

    async def _ask(self, statement: str, subject: str, command_id: str) -> FormerCommand | None:
        asked = _key(subject), _key(command_id), *self._of_run, int(self._contact() * 1000)
        async with self._asking.connection() as connection:
            row = await connection.fetchrow(statement, *asked)
        return None if row is None else _former(row)

    def _put(self, record: Accepted | Ended, done: asyncio.Future[None] | None = None) -> None:
        if len(self._queue) >= self._most:
            self.lost += 1
            if done is not None:
                done.set_result(None)
            return
        self._queue.append(_Waiting(next(self._numbers), record, done))
        self._loop.wake()

    def _next_batch(self) -> list[_Waiting]:
        """Return the next records. What is accepted is written before what ended: one that is accepted again waits."""
        batch, known = [], set()
        for each in islice(self._queue, _BATCH):
            key = each.record.session, each.record.command_id
            if isinstance(each.record, Accepted) and key in known:
                break
            known.add(key)
            batch.append(each)
        return batch

    async def _write(self) -> bool:
        """Write one batch; tell whether that worked."""
        batch = self._next_batch()
        try:
            async with self._writing.connection() as connection:
                await self._write_records(connection, batch)
        except StoreUnreachable as error:
            self.failures += 1
            if not self.failing:
                _log.error("the journal cannot be written: %s; commands go on without it", error)
            self.failing = True
        else:
            self.written += len(batch)
            if self.failing:
                _log.info("the journal in %s is written again", self._name)
            self.failing = False
            for _ in batch:
                self._queue.popleft()
        for each in batch:
            if each.done is not None and not each.done.done():
                each.done.set_result(None)
        return not self.failing

    async def _write_records(self, connection: "Connection", batch: list[_Waiting]) -> None:
        accepted = [
            (each.number, record.session, _key(record.command_id), _key(record.subject), storable(record.component_ref))
            for each in batch
            if isinstance(record := each.record, Accepted)
        ]
        ended = [
            (
                *(record.session, _key(record.command_id), record.status.value),
                *(storable(record.reason), written_results(record.results)),
            )
            for each in batch
            if isinstance(record := each.record, Ended)
        ]
        for statement, rows in ((self._accepted, accepted), (_ENDED, ended)):
            if rows:
                await connection.execute(statement, *self._of_run, *map(list, zip(*rows, strict=True)))
        self._unpruned += len(ended)
        if self._unpruned >= _PRUNE_AFTER:
            await connection.execute(_PRUNE, *self._of_run, MAX_ENDED)
            await connection.execute(self._forget)
            self._unpruned = 0


def _key(text: str) -> bytes:
    """Return the digest under which a text is found: texts of clients may be too long for an index."""
    return sha256(text.encode(errors="surrogatepass")).digest()


def _former(row: "Record") -> FormerCommand:
    status = None if row["status"] in (None, _INTERRUPTED) else CompletedStatus(row["status"])
    reason = GATEWAY_LOST if status is None and not row["is_running"] else row["reason"]
    kept = read_results(row["results"])
    return FormerCommand(row["component_ref"], status, reason, kept, row["is_told"], row["is_running"])
