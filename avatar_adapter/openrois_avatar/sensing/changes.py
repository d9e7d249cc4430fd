"""What of a stream of findings is worth telling: another number, a movement that is far and late enough."""

import math
from collections.abc import Mapping
from typing import Final, NamedTuple

__all__ = ["Movements", "Numbers", "Place"]

_MILLIMETRES: Final = 1000
_MILLISECOND: Final = 0.001


class Place(NamedTuple):
    """Where something is: metres and radians, in the axes of whoever tells; `th` counts counter-clockwise from x."""

    x: float
    y: float
    th: float

    @property
    def text(self) -> str:
        """What stands in `position_data`: `x,y,th`."""
        return f"{self.x:.3f},{self.y:.3f},{self.th:.4f}"


class Numbers:
    """Tells a number when it is another one than the last that was told; in the beginning that is none, 0."""

    def __init__(self) -> None:
        self._told = 0
        self._is_known = True

    def begin(self) -> None:
        """Begin anew: some who listen now may have heard nothing, and others the last number that was told."""
        self._is_known = self._told == 0

    def tells(self, number: int) -> bool:
        """Take a number; whether it has to be told."""
        if number == self._told and self._is_known:
            return False
        self._told, self._is_known = number, True
        return True


class Movements:
    """Tells places when one has moved far enough since it was last told, came, or went; and not too often.

    What is held back because it is too early is told later, if it is still true then. Compared is with what was told:
    slow movements add up.
    """

    def __init__(self) -> None:
        self._told: dict[str, Place] = {}
        self._told_at = -math.inf

    def tells(self, places: Mapping[str, Place], now: float, threshold: int | None, interval: int | None) -> bool:
        """Take all places there are, by their refs; whether they have to be told.

        Where nothing is left there is nothing to tell; whatever comes next has come.

        Args:
            places: where things are now.
            now: seconds of any steady clock.
            threshold: the millimetres that are not far enough; None is 0, so that every movement is told.
            interval: the milliseconds that have to lie between two times; None is 0.
        """
        if not places:
            self._told = {}
            return False
        # A sum, as who waits for the end of the interval has it: rounded otherwise, that would still be too early.
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
