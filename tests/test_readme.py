"""What the README shows is what was tried."""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


@pytest.mark.parametrize("example", sorted((ROOT / "docs/examples").glob("*.py")), ids=lambda path: path.stem)
def test_an_example_is_shown_as_it_is(example: Path) -> None:
    source = example.read_text()
    assert f"```python\n{source}```" in README
    assert len(source.splitlines()) < 30
