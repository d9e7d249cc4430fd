"""How many applications are streamed to at a time, and for whom of them places are kept. Pure."""

from collections.abc import Collection, Hashable, Mapping
from dataclasses import dataclass
from typing import Final, TypeVar

__all__ = ["KEPT_FOR_OPERATORS", "SESSIONS_LIMIT", "PlaceRules", "kept_places"]

Name = TypeVar("Name", bound=Hashable)

SESSIONS_LIMIT: Final = 64
"""Applications at once. Each costs about 1 % of a core for each stream that plays."""

KEPT_FOR_OPERATORS: Final = 16
"""Places that applications which may not bind leave free, or a quarter of all where that is less."""

ANSWER_TIME: Final = 2.0
"""Seconds that an offer may stay unanswered before its place is another application's that wants it."""


def kept_places(applications: int) -> int:
    """Return how many places of so many are kept for applications that may bind, unless a number is given."""
    return min(KEPT_FOR_OPERATORS, applications // 4)


@dataclass(frozen=True, slots=True)
class PlaceRules:
    """The places of one engine.

    Attributes:
        applications: how many there are.
        kept_for_operators: how many of them those leave free that may not bind.
        answer_time: seconds that an unanswered offer holds a place that others want.
    """

    applications: int = SESSIONS_LIMIT
    kept_for_operators: int = KEPT_FOR_OPERATORS
    answer_time: float = ANSWER_TIME

    def __post_init__(self) -> None:
        if not 1 <= self.applications <= 4096:
            raise ValueError(f"--applications must be 1 to 4096, not {self.applications}")
        if not 0 <= self.kept_for_operators < self.applications:
            raise ValueError(
                f"--kept-for-operators must be 0 to {self.applications - 1}, fewer than --applications, "
                f"not {self.kept_for_operators}"
            )
        if not 0 <= self.answer_time <= 60:
            raise ValueError(f"--answer-time must be 0 to 60 seconds, not {self.answer_time}")

    def has_room(self, taken: Collection[bool], may_bind: bool) -> bool:
        """Tell whether one more application has a place.

        Args:
            taken: of each that has one, whether it may bind.
            may_bind: whether the one more may.
        """
        guests = sum(not each for each in taken)
        return len(taken) < self.applications and (may_bind or guests < self.applications - self.kept_for_operators)

    def displaced(self, taken: Mapping[Name, bool], unanswered: Mapping[Name, float], may_bind: bool) -> Name | None:
        """Return which application gives its place to one more, for which there is no room; None for none.

        Args:
            taken: of each that has one, whether it may bind.
            unanswered: of each whose offers were never answered, for how many seconds.
            may_bind: whether the one more may.
        """
        over = [each for each, seconds in unanswered.items() if seconds >= self.answer_time]
        # One that may not bind takes no place of those that may.
        over = [each for each in over if may_bind or not taken[each]]
        return max(over, key=lambda each: (not taken[each], unanswered[each]), default=None)
