"""The versions of a journal: an older one is carried over, and a newer one is kept for the version that can read it."""

import logging
import shutil
import sqlite3
import stat
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from openrois.journal.file import JournalFile, JournalUnusable
from openrois.journal.former import RESTARTED
from openrois.journal.records import Accepted, Presence
from openrois.journal.schema import migrate
from openrois.types.codes import CompletedStatus

FIXTURE = Path(__file__).with_name("journal-0.1.0.sqlite")
"""What a gateway of 0.1.0 left behind that was killed: one command had ended, one had failed, one was running."""

WRITTEN = 1795377264.0
"""When that was: with the wall clock the commands in it would be forgotten."""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "journal.sqlite"
    shutil.copy(FIXTURE, path)
    return path


def opened(path: Path) -> JournalFile:
    return JournalFile(path, clock=lambda: WRITTEN + 60)


def version_of(path: Path) -> int:
    with closing(sqlite3.connect(path)) as database:
        (version,) = database.execute("PRAGMA user_version").fetchone()
    return int(version)


def test_a_journal_of_0_1_0_is_carried_over(path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert version_of(path) == 1
    caplog.set_level(logging.INFO)
    for _ in range(2):
        journal = opened(path)
        blinked, burned, glows = (journal.former.find("local", name) for name in ("blinked", "burned", "glows"))
        journal.close()
        assert blinked is not None
        assert burned is not None
        assert glows is not None
        assert [(each.name, each.value) for each in blinked.results()] == [("blink", "3")]
        assert (burned.status, burned.reason) == (CompletedStatus.ERROR, "lamp: burn failed: x")
        assert (glows.status, glows.reason) == (None, RESTARTED)
        assert journal.engines == {"lamp_1"}
    assert version_of(path) == 2
    said = [record.getMessage() for record in caplog.records]
    assert said == [f"the journal {path} is of version 2 now; as it was with version 1 it is {path}.version-1"]


def test_it_is_written_as_any_other_afterwards(path: Path) -> None:
    journal = opened(path)
    journal.write([Accepted("s", "new", "ann", "lamp_1/lamp", WRITTEN), Presence("lamp_2", is_there=True)])
    journal.close()
    journal = opened(path)
    journal.close()
    assert journal.former.find("ann", "new") is not None
    assert journal.engines == {"lamp_1", "lamp_2"}


def test_the_older_version_finds_its_file_as_it_was(path: Path) -> None:
    opened(path).close()
    before = path.with_name("journal.sqlite.version-1")
    assert version_of(before) == 1
    assert stat.S_IMODE(before.stat().st_mode) == 0o600
    with closing(sqlite3.connect(before)) as kept, closing(sqlite3.connect(FIXTURE)) as written:
        assert list(kept.iterdump()) == list(written.iterdump())


def test_after_a_rollback_the_next_upgrade_keeps_the_latest(path: Path) -> None:
    opened(path).close()
    shutil.copy(FIXTURE, path)
    with closing(sqlite3.connect(path)) as database:
        database.execute("DELETE FROM command WHERE command_id = 'glows'")
        database.commit()
    opened(path).close()
    with closing(sqlite3.connect(f"{path}.version-1")) as kept:
        assert kept.execute("SELECT command_id FROM command ORDER BY number").fetchall() == [("blinked",), ("burned",)]


class FullDisk(sqlite3.Connection):
    """A database whose copy finds no room."""

    def execute(self, sql: str, parameters: Any = (), /) -> sqlite3.Cursor:
        if sql.startswith("VACUUM INTO"):
            Path(parameters[0]).write_bytes(b"half")
            raise sqlite3.OperationalError("database or disk is full")
        return super().execute(sql, parameters)


def test_where_there_is_no_room_the_copy_of_the_last_upgrade_stays(path: Path) -> None:
    kept = path.with_name("journal.sqlite.version-1")
    opened(path).close()
    content = kept.read_bytes()
    shutil.copy(FIXTURE, path)
    with closing(sqlite3.connect(path, factory=FullDisk)) as database, pytest.raises(sqlite3.OperationalError):
        migrate(database, path)
    assert version_of(path) == 1
    assert kept.read_bytes() == content
    assert sorted(each.name for each in path.parent.iterdir()) == ["journal.sqlite", kept.name]


def test_where_it_cannot_be_kept_nothing_is_changed(path: Path) -> None:
    (path.with_name("journal.sqlite.version-1")).mkdir()
    with pytest.raises(JournalUnusable, match=r"the journal .* cannot be used"):
        opened(path)
    assert version_of(path) == 1


def test_one_of_a_newer_version_is_set_aside_whole(path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA user_version = 99")
    content = path.read_bytes()
    journal = opened(path)
    journal.close()
    assert len(journal.former) == 0
    (aside,) = (each for each in path.parent.iterdir() if each.name.startswith("journal.sqlite."))
    assert sqlite3.connect(aside).execute("SELECT count(*) FROM command").fetchone() == (3,)
    assert len(aside.read_bytes()) == len(content)
    assert caplog.messages == [
        f"the journal {path} is of version 99, which a newer OpenRoIS writes, and this one knows 2; it is {aside} now, "
        "and a new one begins"
    ]
