"""The result of a run, requirement by requirement, for people and for machines."""

import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from openrois_conformance.manifest import Requirement
from openrois_conformance.suite import Outcome, Verdict
from openrois_conformance.table import counted

__all__ = ["Report", "Standing", "as_json"]

_MARGIN = 9
_FRAMES = 12
"""How many of the last frames are shown for a failure."""


class Standing(Enum):
    """The result of a requirement, as far as it was tried."""

    PASSED = "pass"
    FAILED = "FAIL"
    PARTLY = "partly"
    NOT_RUN = "not run"


def _standing_of(verdicts: Sequence[Verdict]) -> Standing:
    """Return what the verdicts of its checks mean for a requirement."""
    outcomes = {verdict.outcome for verdict in verdicts}
    if Outcome.FAILED in outcomes:
        return Standing.FAILED
    if outcomes == {Outcome.PASSED}:
        return Standing.PASSED
    return Standing.PARTLY if Outcome.PASSED in outcomes else Standing.NOT_RUN


@dataclass
class Report:
    """The lines and the numbers of a run.

    Attributes:
        width: characters of a line.
        verbose: whether the frames of every check are shown, and not only the last ones of those that failed.
        counts: how many requirements went how.
        reasons: why how many checks were not run.
    """

    width: int
    verbose: bool = False
    counts: Counter[Standing] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    _shown: set[str] = field(default_factory=set)

    def lines(self, requirement: Requirement, verdicts: Sequence[Verdict], column: int) -> Iterator[str]:
        """Count a requirement and yield its lines.

        Args:
            requirement: which.
            verdicts: of its checks.
            column: how wide its id stands.
        """
        standing = _standing_of(verdicts)
        self.counts[standing] += 1
        head = f"{standing.value:{_MARGIN}}{requirement.id:{column}}  "
        yield from self._wrapped(f"{head}{requirement.text}", " " * len(head))
        for verdict in verdicts:
            yield from self._details(verdict)

    def _details(self, verdict: Verdict) -> Iterator[str]:
        check = verdict.check
        if check.id in self._shown:
            if verdict.outcome is Outcome.FAILED:
                yield f"{' ' * _MARGIN}  {check.id}: as above"
            return
        self._shown.add(check.id)
        if verdict.outcome is Outcome.FAILED:
            yield from self._said(f"{check.id}: {check.title}")
            yield from self._said(f"expected  {verdict.expected}")
            yield from self._said(f"came      {verdict.came}")
        elif verdict.outcome is Outcome.NOT_RUN:
            self.reasons[verdict.came] += 1
        for remark in verdict.remarks:
            yield from self._said(f"note      {remark}")
        frames = verdict.frames if self.verbose else verdict.frames[-_FRAMES:]
        if self.verbose or verdict.outcome is Outcome.FAILED:
            yield from (f"{' ' * _MARGIN}  {frame}" for frame in frames)

    def _said(self, text: str) -> Iterator[str]:
        yield from self._wrapped(" " * (_MARGIN + 2) + text, " " * (_MARGIN + 12))

    def _wrapped(self, text: str, indent: str) -> list[str]:
        return textwrap.wrap(text, max(self.width, 60), subsequent_indent=indent, replace_whitespace=False)

    def summary(self, elsewhere: int) -> Iterator[str]:
        """Yield the last lines.

        Args:
            elsewhere: how many requirements cannot be seen from outside.
        """
        passed, failed, partly, skipped = (self.counts[standing] for standing in Standing)
        total = counted(sum(self.counts.values()), "requirement")
        yield f"{total}: {passed} passed, {failed} failed, {partly} tried in part, {skipped} not run"
        for reason, number in self.reasons.items():
            yield from self._wrapped(f"{counted(number, 'check')} not run: {reason}", "  ")
        if elsewhere:
            yield f"{counted(elsewhere, 'more requirement')} cannot be seen from outside: see `openrois conformance`"


def as_json(requirements: Sequence[Requirement], verdicts: Mapping[str, Verdict]) -> list[dict[str, Any]]:
    """Return the run as JSON values: every requirement with the verdicts of its checks."""
    return [
        {
            "id": requirement.id,
            "text": requirement.text,
            "clause": requirement.clause,
            "level": requirement.level,
            "standing": _standing_of([verdicts[check] for check in requirement.checks]).value,
            "checks": [_verdict(verdicts[check]) for check in requirement.checks],
        }
        for requirement in requirements
    ]


def _verdict(verdict: Verdict) -> dict[str, Any]:
    return {
        "id": verdict.check.id,
        "title": verdict.check.title,
        "outcome": verdict.outcome.value,
        "expected": verdict.expected,
        "came": verdict.came,
        "remarks": list(verdict.remarks),
        "frames": [str(frame) for frame in verdict.frames] if verdict.outcome is Outcome.FAILED else [],
    }
