"""Refusals for the audit trail where somebody is refused at will: of a flood it is told how many were left out."""

from collections.abc import Callable

from openrois.rate import RateLimit

__all__ = ["Flood"]


class Flood:
    """Refusals of one kind.

    Args:
        at_once: how many are told one by one.
        per_second: how many of them in the long run.
        clock: monotonic seconds.
    """

    def __init__(self, at_once: int, per_second: float, clock: Callable[[], float]) -> None:
        self._limit = RateLimit(at_once, per_second, clock)
        self._omitted = 0

    def admits(self) -> bool:
        """Tell whether one more is told; one that is not is counted."""
        admitted = self._limit.admits()
        self._omitted += not admitted
        return admitted

    def told(self, reason: str) -> str:
        """Return what is recorded of one that is told: why it was, and how many were left out before."""
        if not self._omitted:
            return reason
        omitted, self._omitted = self._omitted, 0
        return f"{reason} (and {omitted} more refusals before)"
