"""The page for notebooks: its cells run one after the other, with what they await at the top, as a notebook does it."""

import ast
import inspect
import re
from pathlib import Path
from typing import Any, Final

import pytest

from openrois.client import ConnectionState
from openrois.transport.credentials import Credentials
from tests.support.grounds import Line

pytestmark = pytest.mark.extra(name="base")

PAGE: Final = Path(__file__).parents[3] / "docs/how-to/notebooks.md"
CELLS: Final = re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


async def test_every_cell_runs(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    def dialling(_url: str, _credentials: Credentials) -> Any:
        return line.dial

    monkeypatch.setattr("openrois.client.client.websocket", dialling)
    kept: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(CELLS):
        code = compile(cell, f"cell {number}", "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
        told = eval(code, kept)
        if inspect.isawaitable(told):
            await told
    assert len(CELLS) > 8
    assert line.dialled == 1
    assert [each.target for each in kept["reached"]] == ["lobby"]
    assert kept["going"].done
    assert kept["lamp"].is_on
    assert kept["client"].state is ConnectionState.CLOSED
