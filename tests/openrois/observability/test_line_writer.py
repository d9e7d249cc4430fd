"""Lines reach the file in order, whatever happens to the file; what does not fit is counted there, too."""

import errno
import logging
import os
import threading
from pathlib import Path

import pytest

from openrois.observability import line_writer
from openrois.observability.line_writer import LineWriter


@pytest.fixture(autouse=True)
def _hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(line_writer, "_RETRY", 0.01)


def writer(path: Path, limit: int = 100) -> LineWriter[int]:
    return LineWriter(path, str, lambda lost: f"{lost} lost", limit)


def test_lines_are_appended_in_order_to_a_file_of_its_owner_alone(tmp_path: Path) -> None:
    path = tmp_path / "lines"
    for _ in range(2):
        with writer(path, 5000) as lines:
            assert all(lines.put(number) for number in range(3000))
        assert (len(lines), lines.written, lines.lost, lines.failures) == (0, 3000, 0, 0)
    assert path.read_text().splitlines() == [str(number) for number in range(3000)] * 2
    assert path.stat().st_mode & 0o777 == 0o600


def test_a_file_that_cannot_be_made_is_said_at_once(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), writer(tmp_path / "missing" / "lines"):
        pytest.fail("entered")


def test_a_file_that_was_rotated_is_made_again(tmp_path: Path) -> None:
    path, old = tmp_path / "lines", tmp_path / "lines.1"
    with writer(path) as lines:
        lines.put(1)
        while lines.written < 1 or not path.read_text():
            os.sched_yield()
        path.rename(old)
        lines.put(2)
    assert (old.read_text(), path.read_text()) == ("1\n", "2\n")


def test_what_does_not_fit_is_counted_in_the_file_and_the_dispensable_goes_first(tmp_path: Path) -> None:
    may_render = threading.Event()

    def render(number: int) -> str:
        may_render.wait()
        return str(number)

    path = tmp_path / "lines"
    with LineWriter[int](path, render, lambda lost: f"{lost} lost", 4) as lines:
        lines.put(0)
        while len(lines):
            os.sched_yield()
        assert [lines.put(number, dispensable=True) for number in (1, 2, 3)] == [True, True, False]
        assert [lines.put(number) for number in (4, 5, 6)] == [True, True, False]
        assert (len(lines), lines.lost, lines.limit) == (4, 2, 4)
        may_render.set()
    assert sorted(path.read_text().splitlines()) == ["0", "1", "2", "2 lost", "4", "5"]
    assert path.read_text().endswith("2 lost\n")


def test_a_full_disk_is_tried_again_and_half_a_line_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    real, left, freed = os.write, [3], threading.Event()

    def write(file: int, data: bytes) -> int:
        if freed.is_set():
            return real(file, data)
        if not left[0]:
            raise OSError(errno.ENOSPC, "No space left on device")
        wrote = real(file, data[: left[0]])
        left[0] -= wrote
        return wrote

    monkeypatch.setattr(os, "write", write)
    path = tmp_path / "lines"
    caplog.set_level(logging.INFO)
    with writer(path) as lines:
        lines.put(123456)
        while lines.failures < 3:
            os.sched_yield()
        assert lines.failing
        assert path.read_text() == "123"
        freed.set()
        lines.put(7)
        while lines.failing:
            os.sched_yield()
    assert path.read_text() == "123456\n7\n"
    assert caplog.messages == [f"{path} cannot be written: No space left on device", f"{path} is written again"]


def test_a_disk_that_stays_full_does_not_keep_anybody(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def write(_file: int, _data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "write", write)
    with writer(tmp_path / "lines") as lines:
        lines.put(1)
    assert lines.failing


def test_a_file_that_vanishes_with_its_folder_comes_back(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    path = folder / "lines"
    with writer(path) as lines:
        path.unlink()
        folder.rmdir()
        lines.put(1)
        while not lines.failing:
            os.sched_yield()
        folder.mkdir()
        lines.put(2)
    assert path.read_text() == "1\n2\n"
