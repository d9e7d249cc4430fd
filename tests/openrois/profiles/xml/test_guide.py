"""docs/how-to/profiles.md: its piece of Python runs."""

import re
from pathlib import Path

import pytest

pytestmark = pytest.mark.extra(name="base")

GUIDE = (Path(__file__).parents[4] / "docs" / "how-to" / "profiles.md").read_text(encoding="utf-8")


def test_a_profile_is_written_and_read(capsys: pytest.CaptureFixture[str]) -> None:
    (piece,) = re.findall(r"^```python\n(.*?)^```$", GUIDE, re.DOTALL | re.MULTILINE)
    exec(compile(piece, "docs/how-to/profiles.md", "exec"), {})
    assert capsys.readouterr().out == "navigation ()\n"
