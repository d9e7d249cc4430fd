"""docs/explanation/reliability.md: every test that it names exists."""

import re
from pathlib import Path

TESTS = Path(__file__).parent
PAGE = (TESTS.parent / "docs" / "explanation" / "reliability.md").read_text(encoding="utf-8")
NAMED = {name for cell in re.findall(r"^\|.*\| ([^|]+) \|$", PAGE, re.M) for name in re.findall(r"`([^`]+)`", cell)}


def test_every_row_stands_in_a_table() -> None:
    assert not re.findall(r"\|\n\n\| F\d+", PAGE)


def test_the_modules_and_folders_are_there() -> None:
    modules = {path.name for path in TESTS.rglob("test_*.py")}
    named = {name.partition("::")[0] for name in NAMED}
    gone = {name for name in named if name.endswith(".py") and name.rpartition("/")[2] not in modules}
    gone |= {name for name in named if name.startswith("tests/") and not (TESTS.parent / name).exists()}
    assert gone == set()


def test_the_functions_are_there() -> None:
    sources = "\n".join(path.read_text(encoding="utf-8") for path in TESTS.rglob("test_*.py"))
    named = {name.rpartition("::")[2].rstrip("…") for name in NAMED if not name.endswith(".py")}
    functions = {name for name in named if name.startswith("test_")}
    assert len(functions) > 30
    assert {name for name in functions if not re.search(rf"def {name}", sources)} == set()
