"""What is committed is what is generated; and the command that sees to it."""

from pathlib import Path

import pytest
from openrois_codegen.__main__ import main
from openrois_codegen.targets import GENERATED, targets

ROOT = Path(__file__).parents[2]


def test_what_is_committed_is_what_is_generated() -> None:
    stale = [path for path, text in targets(ROOT).items() if (ROOT / path).read_text(encoding="utf-8") != text]
    assert not stale, "run `make generate`"
    assert main(["--check"]) == 0


@pytest.mark.long
def test_it_writes_missing_or_old_files_and_removes_unwanted_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--check"], tmp_path) == 1
    assert not list(tmp_path.iterdir())
    assert main([], tmp_path) == 0
    assert capsys.readouterr().out.splitlines() == list(targets(tmp_path))
    assert main(["--check"], tmp_path) == 0

    (first, *_) = targets(tmp_path)
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
    assert (tmp_path / first).read_text(encoding="utf-8") == targets(tmp_path)[first]


def test_it_is_the_same_every_time() -> None:
    assert targets(ROOT) == targets(ROOT)


def test_of_a_page_the_part_that_is_generated_is_replaced(tmp_path: Path) -> None:
    page = tmp_path / "docs" / "reference" / "conformance.md"
    page.parent.mkdir(parents=True)
    page.write_text("# By hand\n\n<!-- made by: openrois conformance --markdown -->\nold")
    assert main([], tmp_path) == 0
    by_hand, mark, made = page.read_text(encoding="utf-8").partition("<!-- made by")
    assert (by_hand, bool(mark)) == ("# By hand\n\n", True)
    assert "| area |" in made
    assert "old" not in made.splitlines()
    page.write_text(page.read_text(encoding="utf-8").replace("# By hand", "# Still by hand"), encoding="utf-8")
    assert main(["--check"], tmp_path) == 0
