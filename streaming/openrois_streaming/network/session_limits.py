"""Limits on the applications that stream at a time, and the places kept for operators. Pure."""

from collections.abc import Collection, Hashable, Mapping
from dataclasses import dataclass
from typing import Final, TypeVar

__all__ = ["KEPT_FOR_OPERATORS", "SESSIONS_LIMIT", "SessionLimits", "kept_by_default"]

Name = TypeVar("Name", bound=Hashable)

SESSIONS_LIMIT: Final = 64
"""Applications at a time. Each costs about 1 % of a core for each stream that plays."""

KEPT_FOR_OPERATORS: Final = 16
"""Places that only applications which may bind can use, or a quarter of all where that is less."""

ANSWER_TIME: Final = 2.0
"""Seconds that an offer may stay unanswered before another application can take its place."""


def kept_by_default(applications: int) -> int:
    """Return how many places are kept by default for applications that may bind."""
    return min(KEPT_FOR_OPERATORS, applications // 4)


@dataclass(frozen=True, slots=True)
class SessionLimits:
    """Limits of one engine.

    Attributes:
        applications: places in all.
        kept_for_operators: places that only applications which may bind can use.
        answer_time: seconds that an unanswered offer keeps its place while another application waits.
    """

    applications: int = SESSIONS_LIMIT
    kept_for_operators: int = KEPT_FOR_OPERATORS
    answer_time: float = ANSWER_TIME

    def __post_init__(self) -> None:
        if not 1 <= self.applications <= 4096:
            raise ValueError(f"--applications must be between 1 and 4096, not {self.applications}")
        if not 0 <= self.kept_for_operators < self.applications:
            raise ValueError(
                f"--kept-for-operators must be between 0 and {self.applications - 1}, below --applications, "
                f"not {self.kept_for_operators}"
            )
        if not 0 <= self.answer_time <= 60:
            raise ValueError(f"--answer-time must be between 0 and 60 seconds, not {self.answer_time}")

    def has_room(self, taken: Collection[bool], may_bind: bool) -> bool:
        """Return whether there is a place for one more application.

        Args:
            taken: for each application with a place, whether it may bind.
            may_bind: whether the new application may bind.
        """
        guests = sum(not each for each in taken)
        return len(taken) < self.applications and (may_bind or guests < self.applications - self.kept_for_operators)

    def displaced(self, taken: Mapping[Name, bool], unanswered: Mapping[Name, float], may_bind: bool) -> Name | None:
        """Return the application that gives its place to a new one; None if there is none.

        Args:
            taken: for each application with a place, whether it may bind.
            unanswered: seconds for which each application has left its offers unanswered.
            may_bind: whether the new application may bind.
        """
        over = [each for each, seconds in unanswered.items() if seconds >= self.answer_time]
        # An application that may not bind takes no place of one that may.
        over = [each for each in over if may_bind or not taken[each]]
        return max(over, key=lambda each: (not taken[each], unanswered[each]), default=None)
