"""What is in the wheel can be imported without the tests; a program that needs them says so."""

import re
from pathlib import Path

import pytest
from openrois_bench import clone
from openrois_bench.clone import require_clone

from tests.support.packages import ROOT, packages

BENCH = ROOT / "benchmarks/openrois_bench"


def test_no_module_imports_the_tests_when_it_is_imported() -> None:
    found = [
        str(path.relative_to(BENCH))
        for path in sorted(BENCH.rglob("*.py"))
        if re.search(r"^(from|import) (tests|psutil|playwright)\b", path.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    assert found == []


def test_a_clone_is_here() -> None:
    require_clone()


def test_a_program_that_needs_a_clone_says_so(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(clone, "ROOT", tmp_path)
    with pytest.raises(SystemExit, match="run it in the folder of a clone"):
        require_clone()


def test_the_packages_of_a_clone_are_those_that_there_are() -> None:
    folders = {ROOT / Path(path).parent for path in packages()}
    assert set(clone.packages_of(ROOT)) == folders
