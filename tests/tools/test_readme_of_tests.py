"""tests/README.md: every folder of tests answers a question."""

import re
from pathlib import Path

TESTS = Path(__file__).parents[1]


def test_every_folder_has_its_question() -> None:
    page = (TESTS / "README.md").read_text(encoding="utf-8")
    told = re.findall(r"^\| [^|]+ \| `(\w+)` \|$", page.partition("\n## ")[0], re.MULTILINE)
    files = [path.relative_to(TESTS) for path in TESTS.rglob("*") if path.is_file() and path.suffix != ".pyc"]
    assert set(told) == {path.parts[0] for path in files if len(path.parts) > 1}
    assert len(told) == len(set(told))
