"""Which findings of a sense are news: a changed number, a movement that is far and late enough."""

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

__all__ = ["Movements", "Numbers", "Place"]

_MILLIMETRES: Final = 1000
_MILLISECOND: Final = 0.001


class Place(NamedTuple):
    """A place in metres and radians, in the axes of its component; `th` counts counter-clockwise from x."""

    x: float
    y: float
    th: float

    @property
    def text(self) -> str:
        """The text for `position_data`: `x,y,th`."""
        return f"{self.x:.3f},{self.y:.3f},{self.th:.4f}"


class Numbers:
    """Decides when a number has to be announced: when it differs from the last announced one, at first 0."""

    def __init__(self) -> None:
        self._told = 0
        self._is_known = True

    def begin(self) -> None:
        """Begin anew: new subscribers have received nothing, others the last announced number."""
        self._is_known = self._told == 0

    def is_news(self, number: int) -> bool:
        """Return whether a number has to be announced, and note it as announced."""
        if number == self._told and self._is_known:
            return False
        self._told, self._is_known = number, True
        return True


class Movements:
    """Decides when places have to be announced: one moved far enough, appeared or disappeared; and not too often.

    Places that are held back as too early are announced later, if they still differ then. They are compared with the
    announced ones: slow movements add up.
    """

    def __init__(self) -> None:
        self._told: dict[str, Place] = {}
        self._told_at = -math.inf

    def is_news(self, places: Mapping[str, Place], now: float, threshold: int | None, interval: int | None) -> bool:
        """Return whether all places, by their refs, have to be announced, and note them as announced.

        Without any place there is nothing to announce; the next place counts as new.

        Args:
            places: where things are now.
            now: seconds of any steady clock.
            threshold: millimetres up to which a movement is ignored; None is 0, so that every movement counts.
            interval: milliseconds between two announcements at least; None is 0.
        """
        if not places:
            self._told = {}
            return False
        # The same sum as that of a caller that waits for the end of the interval: other rounding would be too early.
        is_early = now < self._told_at + (interval or 0) * _MILLISECOND
        if is_early or not self._far(places, threshold or 0):
            return False
        self._told, self._told_at = dict(places), now
        return True

    def _far(self, places: Mapping[str, Place], threshold: int) -> bool:
        if places.keys() != self._told.keys():
            return True
        return any(
            math.hypot(place.x - self._told[ref].x, place.y - self._told[ref].y) * _MILLIMETRES > threshold
            for ref, place in places.items()
        )
