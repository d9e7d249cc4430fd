"""Findings of the checks: one line for a person, one object for a program."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Final

__all__ = ["Finding", "Outcome", "as_json", "as_text", "failed", "judged", "not_tried", "passed", "summary"]


class Outcome(Enum):
    """The outcome of a check."""

    PASSED = "passed"
    FAILED = "failed"
    NOT_TRIED = "not tried"


_MARKS: Final = {Outcome.PASSED: "ok    ", Outcome.FAILED: "FAILED", Outcome.NOT_TRIED: "-     "}
_PAGE: Final = "docs/reference/engine-link.md"


@dataclass(frozen=True, slots=True)
class Finding:
    """The outcome of one check, what was seen, and the section of `docs/reference/engine-link.md` that it is about."""

    outcome: Outcome
    check: str
    seen: str
    section: str


def passed(check: str, seen: str, section: str) -> Finding:
    """Return a finding of a passed check."""
    return Finding(Outcome.PASSED, check, seen, section)


def failed(check: str, seen: str, section: str) -> Finding:
    """Return a finding of a failed check; `seen` says what is wrong."""
    return Finding(Outcome.FAILED, check, seen, section)


def not_tried(check: str, why: str, section: str) -> Finding:
    """Return a finding of a check without anything to check."""
    return Finding(Outcome.NOT_TRIED, check, why, section)


def judged(check: str, faults: Sequence[str], seen: str, section: str) -> Finding:
    """Return a failed finding with all `faults`, or without any a passed one with `seen`."""
    return failed(check, "; ".join(faults), section) if faults else passed(check, seen, section)


def as_text(finding: Finding) -> str:
    """Return one line; for a failed check with the section to read."""
    where = f" ({_PAGE}, {finding.section})" if finding.outcome is Outcome.FAILED else ""
    return f"{_MARKS[finding.outcome]} {finding.check:<16} {finding.seen}{where}"


def summary(findings: Iterable[Finding]) -> str:
    """Return one line about all findings."""
    outcomes = [finding.outcome for finding in findings]
    numbers = {outcome: outcomes.count(outcome) for outcome in Outcome}
    verdict = "does not follow" if numbers[Outcome.FAILED] else "follows"
    counted = ", ".join(f"{number} {outcome.value}" for outcome, number in numbers.items() if number)
    return f"The engine {verdict} {_PAGE}: {counted}."


def as_json(findings: Iterable[Finding], told: dict[str, object] | None) -> str:
    """Return one JSON object: the engine's HELLO, None without one, and every finding."""
    listed = [{**asdict(finding), "outcome": finding.outcome.value} for finding in findings]
    right = not any(each["outcome"] == Outcome.FAILED.value for each in listed)
    return json.dumps({"passed": right, "engine": told, "findings": listed}, indent=1)
