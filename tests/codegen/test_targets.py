"""What is committed is what is generated; and the command that sees to it."""

from pathlib import Path

import pytest
from openrois_codegen.__main__ import main
from openrois_codegen.targets import GENERATED, targets

ROOT = Path(__file__).parents[2]


def test_what_is_committed_is_what_is_generated() -> None:
    stale = [path for path, text in targets().items() if (ROOT / path).read_text(encoding="utf-8") != text]
    assert not stale, "run `make generate`"
    assert main(["--check"]) == 0


def test_it_writes_what_is_missing_or_old_and_removes_what_nobody_wants(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--check"], tmp_path) == 1
    assert not list(tmp_path.iterdir())
    assert main([], tmp_path) == 0
    assert capsys.readouterr().out.splitlines() == list(targets())
    assert main(["--check"], tmp_path) == 0

    (first, *_) = targets()
    (tmp_path / first).write_text("old")
    stray = tmp_path / Path(GENERATED[0]).parent / "stray.json"
    stray.write_text("{}")
    capsys.readouterr()
    assert main(["--check"], tmp_path) == 1
    said = capsys.readouterr().err
    assert f"{first} is out of date" in said
    assert "stray.json is out of date" in said
    assert main([], tmp_path) == 0
    assert not stray.exists()
    assert (tmp_path / first).read_text(encoding="utf-8") == targets()[first]


def test_it_is_the_same_every_time() -> None:
    assert targets() == targets()
