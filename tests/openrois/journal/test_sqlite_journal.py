"""The journal's thread: commands wait for it a moment at most, whatever the disk does."""

import asyncio
import logging
import sqlite3
import threading
from collections.abc import Iterable
from pathlib import Path

import pytest

from openrois.journal import sqlite_journal as journal_module
from openrois.journal.file import JournalFile
from openrois.journal.records import Record
from openrois.journal.sqlite_journal import SqliteJournal
from openrois.types.codes import CompletedStatus


class Disk(JournalFile):
    """A journal's file on a disk that can be full or stand still."""

    full = False

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.moves = threading.Event()
        self.moves.set()

    def write(self, records: Iterable[Record]) -> None:
        self.moves.wait(5)
        if self.full:
            raise sqlite3.OperationalError("database or disk is full")
        super().write(records)


class Opened:
    """Opens a `Disk`, and keeps it for the test."""

    disk: Disk

    def __call__(self, path: Path) -> JournalFile:
        self.disk = Disk(path)
        return self.disk


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "journal"


async def test_a_command_is_in_the_file_before_it_is_accepted(path: Path) -> None:
    with SqliteJournal(path) as journal:
        await journal.accepted("s", "ann", {"one": "robot/lamp", "two": "robot/lamp"})
        assert (journal.written, journal.waiting, journal.late) == (2, 0, 0)
        journal.ended("s", "one", CompletedStatus.OK, "", ())


async def test_a_disk_that_stands_still_delays_for_a_moment_only(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal_module, "PATIENCE", 0.01)
    opened = Opened()
    with SqliteJournal(path, open_file=opened) as journal:
        opened.disk.moves.clear()
        await journal.accepted("s", "ann", {"one": "robot/lamp"})
        assert (journal.late, journal.written) == (1, 0)
        opened.disk.moves.set()
    with SqliteJournal(path) as again:
        assert await again.find("ann", "one") is not None


async def test_a_disk_that_is_full_stops_no_command_and_is_tried_again(
    path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(journal_module, "_RETRY", 0.01)
    opened = Opened()
    with caplog.at_level(logging.INFO), SqliteJournal(path, open_file=opened) as journal:
        opened.disk.full = True
        for number in range(50):
            await journal.accepted("s", "ann", {str(number): "robot/lamp"})
        assert journal.failing
        assert journal.late == 0
        opened.disk.full = False
        async with asyncio.timeout(60):
            while journal.waiting:
                await journal.accepted("s", "ann", {"more": "robot/lamp"})
    assert len([message for message in caplog.messages if "commands go on without it" in message]) == 1
    assert caplog.messages[-1] == f"the journal {path} is written again"
    with SqliteJournal(path) as again:
        for number in range(50):
            assert await again.find("ann", str(number))


async def test_what_finds_no_room_is_lost_and_counted(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(journal_module, "MAX_WAITING", 3)
    opened = Opened()
    with SqliteJournal(path, open_file=opened) as journal:
        opened.disk.moves.clear()
        for number in range(5):
            journal.ended("s", str(number), CompletedStatus.OK, "", ())
        assert (journal.waiting, journal.lost) == (3, 2)
        await journal.accepted("s", "ann", {"one": "robot/lamp"})
        assert (journal.lost, journal.late) == (3, 0)
        opened.disk.moves.set()
