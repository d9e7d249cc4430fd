"""The conversation in docs/reference/wire.md is one that a gateway has, and each deliberate difference has a test."""

import json
import re
import runpy
from pathlib import Path
from typing import Any

from openrois.testing import memory_gateway

ROOT = Path(__file__).parents[2]


def conversation() -> list[tuple[str, Any]]:
    """Return who says what: `->` the application, `<-` the gateway."""
    page = (ROOT / "docs" / "reference" / "wire.md").read_text(encoding="utf-8")
    (talk,) = re.findall(r"^```text\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    return [(line[:2], json.loads(line[3:])) for line in talk.splitlines()]


async def test_it_goes_as_the_page_says() -> None:
    lamp = runpy.run_path(str(ROOT / "docs" / "examples" / "lamp_adapter.py"))["Lamp"]
    said = conversation()
    assert {speaker for speaker, _ in said} == {"->", "<-"}
    async with memory_gateway(lamp("lamp"), engine_id="lamp_1") as gateway, gateway.dial() as stream:
        for speaker, message in said:
            if speaker == "->":
                await stream.send(json.dumps(message))
            else:
                assert json.loads(await stream.receive()) == message


def test_every_deliberate_difference_is_shown_by_a_test() -> None:
    page = (ROOT / "docs" / "reference" / "conformance.md").read_text(encoding="utf-8")
    (table,) = re.findall(r"^## Where this gateway differs .*?\n\|---[^\n]*\n(.*?)\n\n", page, re.DOTALL | re.MULTILINE)
    rows = [line.strip("| ").split(" | ") for line in table.splitlines()]
    assert all(len(row) == 5 and all(row) for row in rows)
    for *_, reference in rows:
        path, *_, function = reference.strip("`").split("::")
        assert f"def {function}(" in (ROOT / "tests" / path).read_text(encoding="utf-8"), reference
