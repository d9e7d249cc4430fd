"""The manifest for people and for machines: plain text, Markdown, JSON. Pure."""

import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from openrois_conformance.manifest import Area, Level, Requirement

__all__ = ["as_json", "as_markdown", "as_text", "checked_by", "counted"]

_INDENT = "    "


def counted(number: int, what: str) -> str:
    """Return a number with its noun, as in `1 test` and `2 tests`."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"


def checked_by(requirement: Requirement) -> str:
    """Return how a requirement is checked, in a few words."""
    parts = []
    if requirement.checks:
        parts.append(counted(len(requirement.checks), "check"))
    if requirement.tests:
        parts.append(counted(len(requirement.tests), "test"))
    if requirement.gap:
        parts.append("gap")
    return ", ".join(parts)


def _all(areas: Sequence[Area]) -> list[Requirement]:
    return [requirement for area in areas for requirement in area.requirements]


def as_text(areas: Sequence[Area], width: int) -> Iterator[str]:
    """Yield the lines of the whole table.

    Args:
        areas: what to show.
        width: characters of a line.
    """
    for area in areas:
        ids = max(len(requirement.id) for requirement in area.requirements)
        clauses = max(len(requirement.clause) for requirement in area.requirements)
        yield area.title
        yield "-" * len(area.title)
        for requirement in area.requirements:
            head = f"{requirement.id:{ids}}  {requirement.level:9}  {requirement.clause:{clauses}}"
            yield f"{head}  {checked_by(requirement)}".rstrip()
            yield from _wrapped(requirement.text, width, _INDENT)
            if requirement.gap:
                yield from _wrapped(requirement.gap, width, f"{_INDENT}gap: ")
        yield ""
    yield from summary(areas, width)


def _wrapped(text: str, width: int, indent: str) -> list[str]:
    return textwrap.wrap(text, max(width, 40), initial_indent=indent, subsequent_indent=" " * len(indent))


def summary(areas: Sequence[Area], width: int) -> Iterator[str]:
    """Yield the lines with the numbers and the gaps."""
    everything = _all(areas)
    levels = Counter(requirement.level for requirement in everything)
    yield f"{counted(len(everything), 'requirement')}: " + ", ".join(f"{levels[level]} {level}" for level in Level)
    outside = sum(bool(requirement.checks) for requirement in everything)
    tests = sum(bool(requirement.tests) for requirement in everything)
    yield f"{outside:5} are checked from outside, at any gateway: openrois conformance --url ws://127.0.0.1:8765/"
    yield f"{tests:5} are checked by tests of this repository"
    gaps = [requirement for requirement in everything if requirement.gap]
    yield f"{len(gaps):5} are not met, or met otherwise:"
    for requirement in gaps:
        yield from _wrapped(f"{requirement.id}: {requirement.gap}", width, " " * 6)


def as_markdown(areas: Sequence[Area]) -> Iterator[str]:
    """Yield the lines of the table in Markdown."""
    everything = _all(areas)
    levels = Counter(requirement.level for requirement in everything)
    yield "| area | requirements | checked from outside | by tests | gaps |"
    yield "|---|---|---|---|---|"
    for area in areas:
        yield _totals(f"[{area.title}](#{_anchor(area.title)})", area.requirements)
    yield _totals("all", everything)
    yield ""
    yield "By level: " + ", ".join(f"{levels[level]} {level}" for level in Level) + "."
    yield ""
    yield "### Gaps"
    yield "| requirement | what is missing, or done otherwise |"
    yield "|---|---|"
    for requirement in everything:
        if requirement.gap:
            yield f"| `{requirement.id}` | {_cell(requirement.text)} **{_cell(requirement.gap)}** |"
    for area in areas:
        yield ""
        yield f"### {area.title}"
        yield "| id | requirement | clause | level | checked from outside | tests |"
        yield "|---|---|---|---|---|---|"
        for requirement in area.requirements:
            checks = ", ".join(f"`{check}`" for check in requirement.checks)
            yield (
                f"| `{requirement.id}` | {_cell(requirement.text)} | {_cell(requirement.clause)} | {requirement.level} "
                f"| {checks} | {len(requirement.tests) or ''} |"
            )


def _totals(name: str, requirements: Sequence[Requirement]) -> str:
    outside = sum(bool(requirement.checks) for requirement in requirements)
    tests = sum(bool(requirement.tests) for requirement in requirements)
    gaps = sum(bool(requirement.gap) for requirement in requirements)
    return f"| {name} | {len(requirements)} | {outside} | {tests} | {gaps or ''} |"


def _anchor(title: str) -> str:
    return "".join(c for c in title.lower().replace(" ", "-") if c.isalnum() or c in "-_")


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def as_json(areas: Sequence[Area]) -> dict[str, Any]:
    """Return the manifest as JSON values."""
    return {
        "areas": [
            {
                "name": area.name,
                "title": area.title,
                "requirements": [asdict(requirement) for requirement in area.requirements],
            }
            for area in areas
        ]
    }
