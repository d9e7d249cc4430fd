"""What is public: the names that people, programs and configuration files use, wherever the modules behind them stand.

`python -m tests.support.surface` writes `tests/public_surface.json` anew, for a change that is meant.
"""

import contextlib
import hashlib
import importlib
import io
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import entry_points
from pathlib import Path
from typing import Final
from unittest import mock

from openrois_robots.command import ROBOTS

from openrois.cli.__main__ import main
from openrois.gateway.configuration import settings_of
from tests.support.packages import ROOT, packages

__all__ = ["RECORD", "surface"]

RECORD: Final = ROOT / "tests/public_surface.json"
PACKAGES: Final = (
    "openrois",
    "openrois.adapter",
    "openrois.client",
    "openrois.testing",
    "openrois_media",
    "openrois_signaling",
    "openrois_streaming.synthetic",
    "openrois_streaming.testing",
)
"""Packages whose `__all__` is promised."""

_BELOW: Final = re.compile(r"^ {4}([a-z][\w-]*)(?:  |$)", re.MULTILINE)
"""A command below another one, as argparse lists it."""
_ENVIRONMENT: Final = re.compile(r"\bOPENROIS_[A-Z_]*[A-Z]\b")
_METRIC: Final = re.compile(r"\"(openrois_[a-z_]+)\"")
_EXPORT: Final = re.compile(
    r"^export (?:declare )?(?:abstract )?(?:async )?(?:class|function|const|type|interface|enum) (\w+)", re.MULTILINE
)
_PASSED_ON: Final = re.compile(r"^export (?:type )?\{([^}]*)\}", re.MULTILINE)
_ALL_OF: Final = re.compile(r"^export \* from \"(\./[^\"]+)\"", re.MULTILINE)


def surface() -> dict[str, object]:
    """Collect everything that is public, in a form that JSON keeps."""
    return {
        "commands": dict(_commands()),
        "entry points": _entry_points(),
        "environment": sorted(_found(_ENVIRONMENT)),
        "gateway settings": sorted(f"{each.table}.{each.key}" for each in settings_of()),
        "metrics": sorted(_metrics()),
        "names": {name: sorted(importlib.import_module(name).__all__) for name in PACKAGES},
        "schema": _digests(ROOT / "openrois/schema", "*.json"),
        "typescript": {
            name: sorted(_exports(ROOT / f"web_demo/sdk/{name}")) for name in ("index.ts", "media/index.ts")
        },
    }


def _commands() -> Iterator[tuple[str, str]]:
    """Yield the help of each command, and of each command below it."""
    with mock.patch.dict(os.environ, {"COLUMNS": "100"}):
        robots = (("robot", name) for name in ROBOTS)
        waiting: list[tuple[str, ...]] = [(), ("avatar", "check"), *robots]
        waiting += [(each.name,) for each in entry_points(group="openrois.commands")]
        while waiting:
            words = waiting.pop()
            text = _help(words)
            yield " ".join(("openrois", *words)), text
            usage = text.partition("\n\n")[0]
            if words and usage.endswith(" ..."):
                waiting += [(*words, name) for name in _BELOW.findall(text)]


def _help(words: Sequence[str]) -> str:
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown), contextlib.suppress(SystemExit):
        main((*words, "--help"))
    return shown.getvalue()


def _entry_points() -> Mapping[str, list[str]]:
    groups = sorted(group for group in entry_points().groups if group.startswith("openrois."))
    return {group: sorted({each.name for each in entry_points(group=group)}) for group in groups}


def _found(pattern: re.Pattern[str]) -> set[str]:
    files = (path for package in packages() for path in (ROOT / package).rglob("*.py"))
    return {found for path in files for found in pattern.findall(path.read_text(encoding="utf-8"))}


def _metrics() -> set[str]:
    return _found(_METRIC) - {Path(package).name for package in packages()}


def _digests(folder: Path, pattern: str) -> Mapping[str, str]:
    files = sorted(folder.rglob(pattern))
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def _exports(module: Path) -> set[str]:
    """Return what a TypeScript module exports, through the modules that it passes on whole."""
    text = module.read_text(encoding="utf-8")
    names = set(_EXPORT.findall(text))
    for group in _PASSED_ON.findall(text):
        names |= {each.split(" as ")[-1].strip().removeprefix("type ") for each in group.split(",") if each.strip()}
    for other in _ALL_OF.findall(text):
        names |= _exports((module.parent / other).with_suffix(".ts"))
    return names


if __name__ == "__main__":
    RECORD.write_text(json.dumps(surface(), indent=1, sort_keys=True) + "\n", encoding="utf-8")
