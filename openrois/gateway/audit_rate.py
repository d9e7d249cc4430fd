"""Bounds the audit records of one kind of event that clients can cause at will, and counts the rest."""

from collections.abc import Callable

from openrois.aio.rate import RateLimit

__all__ = ["AuditRate"]


class AuditRate:
    """Records of one kind.

    Args:
        at_once: how many are recorded one by one.
        per_second: how many of them in the long run.
        clock: monotonic seconds.
        what: the kind, as the records name it.
    """

    def __init__(self, at_once: int, per_second: float, clock: Callable[[], float], what: str = "refusals") -> None:
        self._what = what
        self._limit = RateLimit(at_once, per_second, clock)
        self._omitted = 0

    def admits(self) -> bool:
        """Tell whether one more is recorded; one that is not is counted."""
        admitted = self._limit.admits()
        self._omitted += not admitted
        return admitted

    def told(self, text: str) -> str:
        """Return the text of a record: its own, and how many were left out before."""
        if not self._omitted:
            return text
        omitted, self._omitted = self._omitted, 0
        return f"{text} (and {omitted} more {self._what} before)"
