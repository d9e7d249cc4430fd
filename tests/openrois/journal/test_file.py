"""The journal's file: what is in it survives, what is not ours is left alone, what is damaged is set aside."""

import logging
import sqlite3
import stat
from contextlib import closing
from pathlib import Path

import pytest

from openrois.journal import file as file_module
from openrois.journal.file import JournalFile, JournalUnusable
from openrois.journal.records import MAX_RESULTS, Accepted, Ended, Presence, Record, Told
from openrois.types.codes import CompletedStatus
from openrois.types.messages import Result

LONG_AGO, NOW = 1.0, 4e9


def accepted(command_id: str, *, session: str = "s", subject: str = "ann", at: float = NOW) -> Accepted:
    return Accepted(session, command_id, subject, "robot/lamp", at)


def ended(command_id: str, value: str = "3", *, status: CompletedStatus = CompletedStatus.OK) -> Ended:
    return Ended("s", command_id, status, "why", (Result(name="total", data_type_ref="integer", value=value),))


def write(path: Path, *records: Record) -> None:
    journal = JournalFile(path)
    journal.write(records)
    journal.close()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "journal"


def test_what_ran_and_what_ended_is_known_to_the_next_run(path: Path) -> None:
    aborted = ended("failed", status=CompletedStatus.ABORT)
    write(path, accepted("runs"), accepted("ended"), accepted("failed"), ended("ended"), aborted)
    for _ in range(2):
        journal = JournalFile(path)
        runs, was, failed = (journal.former.find("ann", name) for name in ("runs", "ended", "failed"))
        journal.close()
        assert runs is not None
        assert was is not None
        assert failed is not None
        assert (runs.status, runs.reason) == (None, "the gateway was restarted")
        assert was.status is CompletedStatus.OK
        assert [each.value for each in was.results()] == ["3"]
        assert (failed.status, failed.reason) == (CompletedStatus.ABORT, "why")
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_what_was_told_is_forgotten(path: Path) -> None:
    write(path, accepted("runs"), accepted("runs", subject="bob", session="t"))
    write(path, Told("ann", "runs"))
    journal = JournalFile(path)
    journal.close()
    assert journal.former.find("ann", "runs") is None
    assert journal.former.find("bob", "runs") is not None


def test_engines_at_the_end_are_known_to_the_next_run(path: Path) -> None:
    write(path, *(Presence(name, is_there=here) for name, here in (("a", True), ("b", True), ("b", False))))
    write(path, Presence("a", is_there=False), Presence("a", is_there=True), Presence("c", is_there=True))
    journal = JournalFile(path)
    assert journal.engines == {"a", "c"}
    assert journal._database.execute("SELECT count(*) FROM engine").fetchone() == (2,)
    journal.close()


def test_a_journal_from_before_engines_were_noted_goes_on(path: Path) -> None:
    write(path, accepted("runs"))
    with closing(sqlite3.connect(path)) as database:
        database.executescript("DROP TABLE engine; PRAGMA user_version = 1;")
    journal = JournalFile(path)
    journal.close()
    assert (journal.engines, len(journal.former)) == (frozenset(), 1)


def test_results_beyond_the_bound_are_not_kept(path: Path) -> None:
    write(path, accepted("one"), ended("one", "x" * MAX_RESULTS))
    journal = JournalFile(path)
    journal.close()
    assert (former := journal.former.find("ann", "one")) is not None
    assert former.kept is None


def test_texts_of_all_kinds(path: Path) -> None:
    ids = ["\ud800", "'); DROP TABLE command; --", "\0", "ü" * 500, ""]
    write(path, *(accepted(command_id) for command_id in ids))
    journal = JournalFile(path)
    journal.close()
    assert len(journal.former) == len(ids)
    for command_id in ids:
        assert journal.former.find("ann", command_id) is not None


def test_it_stays_small(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file_module, "MAX_ENDED", 10)
    monkeypatch.setattr(file_module, "_PRUNE_AFTER", 20)
    journal = JournalFile(path)
    sizes = []
    for batch in range(200):
        names = [f"{batch}-{number}" for number in range(50)]
        journal.write([accepted(name) for name in names])
        journal.write([ended(name, "x" * 1000) for name in names])
        sizes.append(path.stat().st_size + Path(f"{path}-wal").stat().st_size)
    journal.write([accepted("last")])
    journal.close()
    assert max(sizes) < 8 << 20
    assert path.stat().st_size < 1 << 20
    known = JournalFile(path).former
    assert len(known) <= 1 + 10 + 50
    assert known.find("ann", "199-49") is not None


def test_commands_without_a_query_are_dropped_after_days(path: Path) -> None:
    write(path, accepted("old", at=LONG_AGO), accepted("new"))
    journal = JournalFile(path)
    journal.close()
    assert journal.former.find("ann", "old") is None
    assert journal.former.find("ann", "new") is not None


@pytest.mark.parametrize("content", [b"my diary\n", b"SQLite format 2\0"], ids=["text", "another"])
def test_a_file_of_something_else_is_refused_and_left_alone(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with pytest.raises(JournalUnusable, match="is no journal of a gateway"):
        JournalFile(path)
    assert path.read_bytes() == content


def test_the_database_of_something_else_is_refused(path: Path) -> None:
    database = sqlite3.connect(path)
    database.execute("CREATE TABLE recipes (name)")
    database.commit()
    database.close()
    with pytest.raises(JournalUnusable, match="the database of something else"):
        JournalFile(path)


def test_one_gateway_at_a_time(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file_module, "_LOCKED", 0.01)
    first = JournalFile(path)
    with pytest.raises(JournalUnusable, match="another gateway has it"):
        JournalFile(path)
    first.close()
    JournalFile(path).close()


def test_a_place_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(JournalUnusable, match="No such file or directory"):
        JournalFile(tmp_path / "nowhere" / "journal")
    with pytest.raises(JournalUnusable, match="Is a directory"):
        JournalFile(tmp_path)


def test_an_sqlite_without_what_is_needed(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sqlite3, "sqlite_version_info", (3, 30, 0))
    with pytest.raises(JournalUnusable, match="needs SQLite"):
        JournalFile(path)


@pytest.mark.parametrize("seed", range(20))
def test_a_damaged_file_is_set_aside_with_a_line(path: Path, caplog: pytest.LogCaptureFixture, seed: int) -> None:
    write(path, *(accepted(f"{number}") for number in range(2000)))
    content = bytearray(path.read_bytes())
    start = 4096 + seed * 4096
    content[start : start + 4096] = bytes((seed + index) % 256 for index in range(4096))
    path.write_bytes(content)
    caplog.set_level(logging.WARNING)
    journal = JournalFile(path)
    journal.write([accepted("new")])
    journal.close()
    assert [record.getMessage() for record in caplog.records if "is damaged" in record.getMessage()]
    aside = [each for each in path.parent.iterdir() if each.name.startswith("journal.")]
    assert [each.read_bytes() for each in aside] == [bytes(content)]
    assert JournalFile(path).former.find("ann", "new") is not None


DAMAGES = {
    "cut in half": lambda content: content[: len(content) // 2],
    "cut in its first page": lambda content: content[:600],
    "no header": lambda content: content[:16] + bytes(84) + content[100:],
    "no table": lambda content: content.replace(b"CREATE TABLE", b"CREATE CABLE"),
    "no column": lambda content: content.replace(b"command_id TEXT", b"command_ix TEXT"),
    "no status": lambda content: content.replace(b"OKwhy", b"OXwhy"),
    "no text": lambda content: content.replace(b"OKwhy", b"O\xffwhy"),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_whatever_is_damaged_no_gateway_stays_away_for_it(path: Path, damage: str) -> None:
    write(path, *(accepted(f"{number}") for number in range(500)), ended("7"))
    content = path.read_bytes()
    damaged = DAMAGES[damage](content)
    assert damaged != content
    path.write_bytes(damaged)
    write(path, accepted("new"))
    (aside,) = (each for each in path.parent.iterdir() if each.name.startswith("journal."))
    assert aside.read_bytes() == damaged
    assert JournalFile(path).former.find("ann", "new") is not None


def test_a_batch_is_written_whole_or_not_at_all(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    journal = JournalFile(path)
    monkeypatch.setitem(file_module._STATEMENTS, Told, "DELETE FROM nowhere WHERE json_valid(?)")
    with pytest.raises(sqlite3.Error):
        journal.write([accepted("one"), Told("ann", "two")])
    monkeypatch.undo()
    journal.write([accepted("three")])
    journal.close()
    former = JournalFile(path).former
    assert former.find("ann", "one") is None
    assert former.find("ann", "three") is not None
