"""The command line as it was recorded: the help of every command."""

import json
from pathlib import Path
from typing import Final

__all__ = ["commands"]

_RECORD: Final = Path(__file__).parents[2] / "tests" / "public_surface.json"
"""A test compares it with what the commands print."""


def commands() -> list[str]:
    """Return a heading and the help of each command, the shortest name of a family first."""
    record: dict[str, str] = json.loads(_RECORD.read_text(encoding="utf-8"))["commands"]
    return [line for name, text in sorted(record.items()) for line in _section(name, text)][1:]


def _section(name: str, text: str) -> list[str]:
    shown = text.rstrip().splitlines()
    return ["", f"{'###' if name.count(' ') > 1 else '##'} {name}", "", "```text", *shown, "```"]
