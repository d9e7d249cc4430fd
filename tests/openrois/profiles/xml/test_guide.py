"""docs/profiles.md: its piece of Python runs."""

import re
from pathlib import Path

import pytest

GUIDE = (Path(__file__).parents[4] / "docs" / "profiles.md").read_text(encoding="utf-8")


def test_a_profile_is_written_and_read(capsys: pytest.CaptureFixture[str]) -> None:
    (piece,) = re.findall(r"^```python\n(.*?)^```$", GUIDE, re.DOTALL | re.MULTILINE)
    exec(compile(piece, "docs/profiles.md", "exec"), {})
    assert capsys.readouterr().out == "navigation ()\n"
