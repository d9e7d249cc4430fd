"""The corpus of messages that the tests of every language read."""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from openrois.schema import VERSION

__all__ = ["FOLDER", "Case", "corpus"]

FOLDER = Path(__file__).parents[1] / "corpus" / VERSION


@dataclass(frozen=True, slots=True)
class Case:
    """A message; `kind` is what is wrong with it, empty where nothing is."""

    name: str
    message: Any
    kind: str = ""

    @property
    def is_valid(self) -> bool:
        return not self.kind


@cache
def corpus() -> dict[str, tuple[Case, ...]]:
    """Return the cases of each type."""
    files = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(FOLDER.glob("*.json"))]
    return {file["type"]: tuple(Case(**case) for case in (*file["valid"], *file["invalid"])) for file in files}
