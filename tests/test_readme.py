"""What the README and the docs show is what was tried."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
PAGES = [README, *(page.read_text() for page in sorted((ROOT / "docs").rglob("*.md")))]


APPLICATION = [ROOT / "docs/examples" / name for name in ("guide.py", "small_talk.py", "steady_voice.py")]
"""An application that is too long to be shown: its page shows pieces."""


@pytest.mark.parametrize(
    "example", sorted({*(ROOT / "docs/examples").glob("*.py")} - {*APPLICATION}), ids=lambda path: path.stem
)
def test_an_example_is_shown_as_it_is(example: Path) -> None:
    source = example.read_text()
    shown = [page for page in PAGES if f"```python\n{source}```" in page]
    assert shown
    assert len(source.splitlines()) < (30 if README in shown else 70), "short enough to be read where it is shown"


def test_the_page_of_the_guide_shows_pieces_of_it_as_they_are() -> None:
    page = (ROOT / "docs/how-to/guide.md").read_text()
    source = "".join(example.read_text() for example in APPLICATION)
    pieces = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert pieces
    assert [piece for piece in pieces if piece not in source] == []
    assert [example.name for example in APPLICATION if f"../examples/{example.name}" not in page] == []


def test_what_the_page_of_the_guide_says_that_it_says_is_said() -> None:
    rows = [line for line in (ROOT / "docs/how-to/guide.md").read_text().splitlines() if line.startswith("|")]
    tried = "".join(test.read_text() for test in (ROOT / "tests/agents/guide").glob("*.py"))
    sentences = re.findall(r'"([A-Z][^"]*\.|\w+ (?:has|may have) [^"]*\.)"', "\n".join(rows))
    assert len(sentences) > 8
    assert [sentence for sentence in sentences if sentence not in tried] == []
