"""docs/how-to/testing.md: every piece of Python in it runs, and its tests pass."""

import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.extra(name="demo")

PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "testing.md"
PIECES = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def written() -> dict[str, Any]:
    """Return what all pieces define, one after the other."""
    defined: dict[str, Any] = {"__name__": "testing_page"}
    for number, piece in enumerate(PIECES):
        exec(compile(piece, f"{PAGE}, piece {number}", "exec"), defined)
    return defined


TESTS = {name: value for name, value in written().items() if name.startswith("test_")}


def test_no_piece_is_left_out() -> None:
    assert len(TESTS) == len(PIECES) == 6


@pytest.mark.media
@pytest.mark.parametrize("test", TESTS.values(), ids=TESTS.keys())
async def test_its_tests_pass(test: Callable[..., Any], request: pytest.FixtureRequest) -> None:
    await test(**{name: request.getfixturevalue(name) for name in inspect.signature(test).parameters})
