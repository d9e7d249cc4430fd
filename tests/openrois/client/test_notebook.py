"""The pages for notebooks and of bodies: their cells run one after the other, with what they await at the top."""

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

PAGES: Final = Path(__file__).parents[3] / "docs/how-to"


def cells(page: str) -> list[str]:
    """Return the pieces of Python of a page; whole programs, which other tests run, are none."""
    text = (PAGES / page).read_text(encoding="utf-8")
    pieces = re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    return [piece for piece in pieces if 'if __name__ == "__main__"' not in piece]


async def run_cells(page: str) -> dict[str, Any]:
    """Run what a page shows from its first piece to its last; return the names that there are then."""
    kept: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(cells(page)):
        code = compile(cell, f"cell {number}", "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
        told = eval(code, kept)
        if inspect.isawaitable(told):
            await told
    return kept


@pytest.fixture
def dialled(line: Line, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every address lead to the gateway in memory."""

    def dialling(_url: str, _credentials: Credentials) -> Any:
        return line.dial

    monkeypatch.setattr("openrois.client.client.websocket", dialling)


async def test_every_cell_runs(line: Line, dialled: None) -> None:
    kept = await run_cells("notebooks.md")
    assert len(cells("notebooks.md")) > 8
    assert line.dialled == 1
    assert [each.target for each in kept["reached"]] == ["lobby"]
    assert kept["going"].done
    assert kept["lamp"].is_on
    assert kept["client"].state is ConnectionState.CLOSED


async def test_the_page_of_bodies_says_what_is_so(
    line: Line, dialled: None, capsys: pytest.CaptureFixture[str]
) -> None:
    await run_cells("bodies.md")
    said, robot, toys = capsys.readouterr().out.splitlines()
    assert said == "robot can react"
    assert line.robot.parts["SpeechSynthesis"].done == ["start"]
    assert robot.startswith("robot free robot/audio_streaming")
    assert toys == "toys free toys/bell toys/lamp"
