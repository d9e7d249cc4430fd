"""What the README and the docs show is what was tried."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()
PAGES = [README, *(page.read_text() for page in sorted((ROOT / "docs").rglob("*.md")))]


@pytest.mark.parametrize("example", sorted((ROOT / "docs/examples").glob("*.py")), ids=lambda path: path.stem)
def test_an_example_is_shown_as_it_is(example: Path) -> None:
    source = example.read_text()
    shown = [page for page in PAGES if f"```python\n{source}```" in page]
    assert shown
    assert len(source.splitlines()) < (30 if README in shown else 70), "short enough to be read where it is shown"
