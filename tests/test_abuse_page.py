"""docs/explanation/abuse.md: every case has a row, and every test that it names exists."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "explanation" / "abuse.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (T\d+) \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", PAGE, re.M)


def test_every_case_has_a_row() -> None:
    assert [case for case, *_ in ROWS] == [f"T{number}" for number in range(1, 34)]


def test_the_tests_are_there() -> None:
    gone = []
    for case, _, _, tests in ROWS:
        references = [each.strip("` ") for each in tests.split(", ")]
        for reference in references:
            path, _, name = reference.partition("::")
            file = ROOT / path
            if not file.is_file() or not re.search(rf"def {name}\(", file.read_text(encoding="utf-8")):
                gone.append((case, reference))
    assert gone == []
