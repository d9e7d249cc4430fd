"""The file of the journal: an SQLite database of running commands, a bounded number of ended ones, and engines."""

import json
import logging
import os
import sqlite3
import time
from collections.abc import Callable, Iterable
from contextlib import closing, suppress
from pathlib import Path
from typing import Final

from openrois.journal.former import RESTARTED, FormerCommand, FormerCommands
from openrois.journal.records import (
    KEPT_FOR,
    MAX_ENDED,
    Accepted,
    Ended,
    Presence,
    Record,
    Told,
    read_results,
    storable,
    written_results,
)
from openrois.journal.schema import APPLICATION_ID, VERSION, create, migrate, version_of
from openrois.types.codes import CompletedStatus

__all__ = ["JournalFile", "JournalUnusable"]

_log = logging.getLogger(__name__)

MAX_PAGES: Final = 16_384
"""Of 4 KiB: a bound that what is kept does not come near to."""

_MAGIC: Final = b"SQLite format 3\0"
_SQLITE: Final = (3, 38)
_LOCKED: Final = 0.5
_PRUNE_AFTER: Final = 1024
_INTERRUPTED: Final = "INTERRUPTED"
_PRUNE: Final = """
    DELETE FROM command WHERE status IS NOT NULL AND number <=
    (SELECT number FROM command WHERE status IS NOT NULL ORDER BY number DESC LIMIT 1 OFFSET ?)
"""
_OF_THE_PLACE: Final = frozenset(
    {
        sqlite3.SQLITE_PERM,
        sqlite3.SQLITE_BUSY,
        sqlite3.SQLITE_LOCKED,
        sqlite3.SQLITE_NOMEM,
        sqlite3.SQLITE_READONLY,
        sqlite3.SQLITE_IOERR,
        sqlite3.SQLITE_FULL,
        sqlite3.SQLITE_CANTOPEN,
    }
)
"""Errors of the disk, or of another process at the file; all others of SQLite are errors in the file."""


class JournalUnusable(Exception):
    """The file cannot be a journal; the text says why, in one line."""


_STATEMENTS: Final[dict[type[Record], str]] = {
    Accepted: """
        INSERT OR REPLACE INTO command (session, command_id, subject, component_ref, accepted)
        SELECT value->>0, value->>1, value->>2, value->>3, value->>4 FROM json_each(?)
    """,
    Ended: """
        UPDATE command SET status = value->>2, reason = value->>3, results = value->>4 FROM json_each(?)
        WHERE session = value->>0 AND command_id = value->>1
    """,
    Told: """
        DELETE FROM command WHERE status IS NOT NULL AND (subject, command_id) IN
        (SELECT value->>0, value->>1 FROM json_each(?))
    """,
    Presence: "INSERT OR REPLACE INTO engine SELECT value->>0, value->>1 FROM json_each(?)",
}


class JournalFile:
    """The open file; its methods block, so that they belong into a thread. One process has it at a time.

    What was written survives the end of the process, however it ends. After a loss of power the last moments may be
    missing, and the file is sound.

    Args:
        path: the file, made with mode 0600. One of an older version is carried over, and stays beside it as it was.
        clock: epoch seconds.

    Attributes:
        former: what former runs left.
        engines: those that were attached at the end of the last run.

    Raises:
        JournalUnusable: it is a file of something else, or another gateway has it, or it cannot be written. One that is
            damaged or of a newer version is set aside instead, with a line in the log.
    """

    def __init__(self, path: Path, *, clock: Callable[[], float] = time.time) -> None:
        self.path = path
        if sqlite3.sqlite_version_info < _SQLITE:
            raise JournalUnusable(f"a journal needs SQLite 3.38, and this Python has {sqlite3.sqlite_version}")
        self.former = FormerCommands()
        self.engines: frozenset[str] = frozenset()
        self._clock = clock
        self._unpruned = _PRUNE_AFTER
        try:
            self._require_ours()
            if wrong := self._begin():
                self._set_aside(wrong)
                self._begin()
        except (OSError, sqlite3.Error) as error:
            raise JournalUnusable(f"the journal {path} cannot be used: {_said(error)}") from error

    def close(self) -> None:
        """Close it."""
        with suppress(sqlite3.Error):
            self._database.close()

    def write(self, records: Iterable[Record]) -> None:
        """Write records, all or none.

        Raises:
            sqlite3.Error: they could not be written, for the disk is full or gone.
        """
        rows: dict[type[Record], list[tuple[object, ...]]] = {kind: [] for kind in _STATEMENTS}
        for record in records:
            rows[type(record)].append(_row(record))
        self._unpruned += len(rows[Ended])
        try:
            self._database.execute("BEGIN")
            for kind, of_kind in rows.items():
                if of_kind:
                    # One statement for all of them: each one costs a change of threads.
                    self._database.execute(_STATEMENTS[kind], (json.dumps(of_kind),))
            if rows[Presence]:
                self._database.execute("DELETE FROM engine WHERE NOT is_there")
            if self._unpruned >= _PRUNE_AFTER:
                self._database.execute(_PRUNE, (MAX_ENDED,))
                self._unpruned = 0
            self._database.execute("COMMIT")
        except sqlite3.Error:
            if self._database.in_transaction:
                self._database.execute("ROLLBACK")
            raise

    def _require_ours(self) -> None:
        """Refuse a file that is no database: a file named by mistake stays as it is."""
        os.close(os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600))
        with self.path.open("rb") as file:
            head = file.read(len(_MAGIC))
        if head not in (b"", _MAGIC):
            raise JournalUnusable(f"{self.path} is no journal of a gateway; name another file, or move it away")

    def _begin(self) -> str:
        """Open the database and read what is in it; return why that cannot be, or nothing."""
        self.former = FormerCommands()
        self._database = sqlite3.connect(self.path, timeout=_LOCKED, isolation_level=None, check_same_thread=False)
        try:
            wrong = self._set_up()
            if not wrong:
                self._load(self._clock())
                return ""
        except (sqlite3.Error, ValueError) as error:
            self.close()
            if _is_of_the_place(error):
                raise
            wrong = "damaged"
        except (OSError, JournalUnusable):
            self.close()
            raise
        self.close()
        return wrong

    def _set_up(self) -> str:
        """Set the database up where it is new or old; return why it cannot be used, or nothing."""
        _set_pragmas(self._database)
        if self._database.execute("SELECT count(*) FROM sqlite_master").fetchone() == (0,):
            create(self._database)
            return ""
        if self._database.execute("PRAGMA application_id").fetchone() != (APPLICATION_ID,):
            raise JournalUnusable(f"{self.path} is the database of something else; name another file")
        version = version_of(self._database)
        if version > VERSION:
            return f"of version {version}, which a newer OpenRoIS writes, and this one knows {VERSION}"
        if version < 1 or self._database.execute("PRAGMA quick_check(1)").fetchone() != ("ok",):
            return "damaged"
        if kept := migrate(self._database, self.path):
            _log.info(
                "the journal %s is of version %d now; as it was with version %d it is %s",
                *(self.path, VERSION, version, kept),
            )
        return ""

    def _set_aside(self, wrong: str) -> None:
        aside = self.path.with_name(f"{self.path.name}.{time.strftime('%Y%m%dT%H%M%S', time.gmtime())}")
        _log.warning("the journal %s is %s; it is %s now, and a new one begins", self.path, wrong, aside)
        self.path.rename(aside)
        for more in ("-wal", "-shm"):
            with suppress(FileNotFoundError):
                Path(f"{self.path}{more}").rename(f"{aside}{more}")
        self._require_ours()

    def _load(self, now: float) -> None:
        """Read what former runs left; what ran then has ended."""
        self._database.execute("DELETE FROM command WHERE accepted < ?", (now - KEPT_FOR,))
        with closing(self._database.execute("SELECT * FROM command ORDER BY number")) as rows:
            for _, _, command_id, subject, component_ref, _, status, reason, results in rows:
                ended = None if status in (None, _INTERRUPTED) else CompletedStatus(status)
                reason = RESTARTED if ended is None else reason
                command = FormerCommand(component_ref, ended, reason, read_results(results))
                self.former.put(subject, command_id, command)
        with closing(self._database.execute("SELECT engine_id FROM engine WHERE typeof(engine_id) = 'text'")) as rows:
            self.engines = frozenset(engine_id for (engine_id,) in rows)
        self._database.execute(
            "UPDATE command SET status = ?, reason = ? WHERE status IS NULL", (_INTERRUPTED, RESTARTED)
        )


def _set_pragmas(database: sqlite3.Connection) -> None:
    for pragma in (
        # One process, and no memory shared with others.
        "locking_mode = EXCLUSIVE",
        "journal_mode = WAL",
        "synchronous = NORMAL",
        "journal_size_limit = 4194304",
        f"max_page_count = {MAX_PAGES}",
    ):
        with suppress(sqlite3.NotSupportedError):
            database.execute(f"PRAGMA {pragma}")


def _is_of_the_place(error: Exception) -> bool:
    """Tell whether an error is not about the file: one that is cut short is damaged, and no fault of the disk."""
    code = getattr(error, "sqlite_errorcode", None)
    return code is not None and code & 0xFF in _OF_THE_PLACE and code != sqlite3.SQLITE_IOERR_SHORT_READ


def _said(error: Exception) -> str:
    if isinstance(error, sqlite3.OperationalError) and "locked" in str(error):
        return "another gateway has it"
    return getattr(error, "strerror", None) or str(error)


def _row(record: Record) -> tuple[object, ...]:
    match record:
        case Accepted(session, command_id, subject, component_ref, at):
            return session, storable(command_id), storable(subject), storable(component_ref), at
        case Ended(session, command_id, status, reason, results):
            return session, storable(command_id), status.value, storable(reason), written_results(results)
        case Told(subject, command_id):
            return storable(subject), storable(command_id)
        case Presence(engine_id, is_there):
            return engine_id, is_there
