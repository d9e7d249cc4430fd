"""The visitor that a body attends to, chosen among several, and kept for a while. Pure; time is an argument."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from openrois_streaming.source.loudness import FLOOR

__all__ = ["DWELL", "LOUDEST", "NEAREST", "PATIENCE", "AttentionRule", "Candidate"]

NEAREST: Final = "nearest"
LOUDEST: Final = "loudest"

DWELL: Final = 2.0
"""Seconds for which a visitor is attended to at least, unless it leaves or another one is named."""

PATIENCE: Final = 0.6
"""Seconds for which another visitor has to be nearer or louder all the time."""

_LOUDER: Final = 6.0
"""dB by which another visitor has to be louder."""

_AUDIBLE: Final = -45.0
"""dBFS below which a microphone has no voice near it."""

_NEARER: Final = 1.3
"""Ratio by which the face of another visitor has to be larger in its picture."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A visitor as it is known without an analysis of all that it sends.

    Attributes:
        visitor_ref: its name.
        loudness: of its microphone lately, in dBFS.
        face: share of its picture that its largest face has; 0 for none.
    """

    visitor_ref: str
    loudness: float = FLOOR
    face: float = 0.0


class AttentionRule:
    """Chooses whom to attend to: by `nearest`, `loudest`, or the visitor that is named. It does not flap.

    Where no visitor shows a face `nearest` is `loudest`; without a voice the visitor that came first is attended to.
    """

    def __init__(self) -> None:
        self.attended = ""
        """The visitor_ref of who is attended to; empty for none."""
        self._since = 0.0
        self._rival = ""
        self._rival_since = 0.0

    def choose(self, mode: str, candidates: Sequence[Candidate], now: float) -> str:
        """Return whom to attend to now.

        Args:
            mode: `nearest`, `loudest`, or a visitor_ref; that of a visitor who is not there counts as `nearest`.
            candidates: those who are there, the first that came first.
            now: seconds of any steady clock.
        """
        known = {each.visitor_ref: each for each in candidates}
        best = _best(mode, candidates)
        current = known.get(self.attended)
        if mode in known:
            self._attend(mode, now)
        elif best is None or current is None:
            self._attend("" if best is None else best.visitor_ref, now)
        elif best is current or not _is_clear(mode, best, current):
            self._rival = ""
        elif best.visitor_ref != self._rival:
            self._rival, self._rival_since = best.visitor_ref, now
        elif now - self._rival_since >= PATIENCE and now - self._since >= DWELL:
            self._attend(best.visitor_ref, now)
        return self.attended

    def _attend(self, visitor_ref: str, now: float) -> None:
        self._rival = ""
        if visitor_ref != self.attended:
            self.attended, self._since = visitor_ref, now


def _best(mode: str, candidates: Sequence[Candidate]) -> Candidate | None:
    """Return the nearest or loudest candidate; of equal ones the first."""
    if mode != LOUDEST and any(each.face for each in candidates):
        return max(candidates, key=lambda each: each.face)
    return max(candidates, key=lambda each: max(each.loudness, _AUDIBLE), default=None)


def _is_clear(mode: str, rival: Candidate, current: Candidate) -> bool:
    """Tell whether a better candidate is so by enough."""
    if mode != LOUDEST and rival.face:
        return rival.face > current.face * _NEARER
    return rival.loudness > max(current.loudness, _AUDIBLE) + _LOUDER
