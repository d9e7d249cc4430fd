"""What is made once for a whole run of the tests."""

from pathlib import Path

import pytest

from tests.support.once import once


def test_a_folder_is_made_once(tmp_path: Path) -> None:
    made: list[Path] = []

    def make(folder: Path) -> None:
        folder.mkdir()
        made.append(folder)

    assert once(tmp_path / "site", make) == once(tmp_path / "site", make) == tmp_path / "site"
    assert made == [tmp_path / "site"]


@pytest.mark.parametrize("kind", ["folder", "file"])
def test_each_process_is_told_why_it_cannot_be_made_and_the_next_one_begins_anew(tmp_path: Path, kind: str) -> None:
    def make_half(new: Path) -> None:
        if kind == "folder":
            new.mkdir()
            new /= "half"
        with new.open("x"):
            raise RuntimeError("the disk is full")

    for _ in range(2):
        with pytest.raises(RuntimeError, match="the disk is full"):
            once(tmp_path / "built", make_half)

    def make_whole(new: Path) -> None:
        with new.open("x"):
            pass

    assert once(tmp_path / "built", make_whole).is_file()
