"""Findings of the doctor, and their report as lines for a terminal or as JSON. Pure."""

import json
import textwrap
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Final

__all__ = ["Finding", "Level", "as_json", "as_text", "exit_status", "summary"]

_INDENT: Final = 22
_WIDTH: Final = 100


class Level(StrEnum):
    """The level of a finding."""

    OK = "ok"
    WARN = "warn"
    """It works, with less."""
    FAIL = "fail"
    """What was asked about will not work."""


_COLOURS: Final = {Level.OK: "32", Level.WARN: "33", Level.FAIL: "31"}


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report.

    Attributes:
        level: whether it works.
        name: what was looked at.
        detail: what was seen.
        advice: the sentence that says what to change; empty where nothing has to be.
    """

    level: Level
    name: str
    detail: str
    advice: str = ""


def exit_status(findings: Iterable[Finding]) -> int:
    """Return 0 if what was asked about will work, 1 if not."""
    return int(any(finding.level is Level.FAIL for finding in findings))


def as_text(finding: Finding, *, colour: bool) -> str:
    """Return one finding as lines for a terminal."""
    mark = f"{finding.level.value:5}"
    if colour:
        mark = f"\x1b[{_COLOURS[finding.level]}m{mark}\x1b[0m"
    detail, advice = _wrapped(finding.detail), _wrapped(finding.advice)
    lines = [f"{mark} {finding.name:15} {detail[0]}"]
    lines += [" " * _INDENT + line for line in (*detail[1:], *(advice if finding.advice else ()))]
    return "\n".join(lines)


def summary(findings: Sequence[Finding], subject: str = "streams") -> str:
    """Return one line with the number of findings of each level, and whether `subject` will work."""
    counts = {level: sum(finding.level is level for finding in findings) for level in Level}
    told = f"{counts[Level.OK]} ok, {counts[Level.WARN]} to look at, {counts[Level.FAIL]} failed"
    return f"{told}: {subject} will {'not work' if exit_status(findings) else 'work'}"


def as_json(findings: Sequence[Finding]) -> str:
    """Return all findings as one JSON object."""
    return json.dumps(
        {"works": not exit_status(findings), "findings": [asdict(finding) for finding in findings]}, indent=2
    )


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, _WIDTH - _INDENT, break_long_words=False, break_on_hyphens=False) or [""]
