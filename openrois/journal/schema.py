"""The schema of the journal's file by version, and how a file of an older version becomes one of the present."""

import os
import sqlite3
from pathlib import Path
from typing import Final

__all__ = ["APPLICATION_ID", "VERSION", "create", "migrate", "version_of"]

APPLICATION_ID: Final = 0x526F4953
"""`PRAGMA application_id` of a journal: the database of something else is left alone."""

VERSION: Final = 2
"""`PRAGMA user_version` of what is written here."""

_SCHEMA: Final = f"""
    PRAGMA application_id = {APPLICATION_ID};
    PRAGMA user_version = {VERSION};
    CREATE TABLE command (
        number INTEGER PRIMARY KEY,
        session TEXT NOT NULL, command_id TEXT NOT NULL, subject TEXT NOT NULL, component_ref TEXT NOT NULL,
        accepted REAL NOT NULL, status TEXT, reason TEXT NOT NULL DEFAULT '', results TEXT
    );
    CREATE UNIQUE INDEX by_id ON command (session, command_id);
    CREATE INDEX by_end ON command (status, number);
    CREATE TABLE engine (engine_id TEXT PRIMARY KEY, is_there INTEGER NOT NULL);
"""
_STEPS: Final = {
    # 0.1.0: its first files had no table of engines.
    1: "CREATE TABLE IF NOT EXISTS engine (engine_id TEXT PRIMARY KEY, is_there INTEGER NOT NULL);",
}
"""What makes of a file of each older version one of the next."""


def create(database: sqlite3.Connection) -> None:
    """Make the tables of the present version in an empty database."""
    database.executescript(_SCHEMA)


def version_of(database: sqlite3.Connection) -> int:
    """Return the version that a database says it has."""
    (version,) = database.execute("PRAGMA user_version").fetchone()
    return int(version)


def migrate(database: sqlite3.Connection, path: Path) -> Path | None:
    """Carry a database of an older version over to the present one, all or nothing.

    Args:
        database: of any version up to the present one, and sound.
        path: its file. As it was it is kept beside it, for the older version to go on with.

    Returns:
        Where it is kept as it was; None where it is of the present version.

    Raises:
        OSError: it could not be kept as it was; nothing has changed.
        sqlite3.Error: likewise, or it could not be carried over.
    """
    version = version_of(database)
    if version == VERSION:
        return None
    kept = path.with_name(f"{path.name}.version-{version}")
    _copy(database, kept)
    steps = "".join(_STEPS[each] for each in range(version, VERSION))
    try:
        database.executescript(f"BEGIN; {steps} PRAGMA user_version = {VERSION}; COMMIT;")
    except sqlite3.Error:
        if database.in_transaction:
            database.execute("ROLLBACK")
        raise
    return kept


def _copy(database: sqlite3.Connection, path: Path) -> None:
    """Write a copy of a database, whole or not at all: a copy that is there already stays until the new one is written.

    Raises:
        OSError: the copy cannot be written, or cannot take its place.
        sqlite3.Error: likewise.
    """
    written = path.with_name(f"{path.name}.new")
    # VACUUM INTO takes an empty file, and this one is readable for its owner alone from the start.
    file = os.open(written, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o600)
    try:
        database.execute("VACUUM INTO ?", (str(written),))
        os.fsync(file)
        written.replace(path)
    except (OSError, sqlite3.Error):
        written.unlink(missing_ok=True)
        raise
    finally:
        os.close(file)
