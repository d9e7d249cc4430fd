"""A person who walks about on a round, and waits while a robot is in the way. Pure."""

from math import atan2, dist, hypot
from typing import Final

from openrois_body.messages import Place, Point

__all__ = ["Visitor"]

_SPEED: Final = 0.6
"""Metres a second: slower than the robot, so that it can follow."""
_PAUSE: Final = 3.0
"""Seconds at each point of the round."""
_APART: Final = 0.75
"""Metres, middle to middle, at which the visitor waits for a robot ahead."""


class Visitor:
    """The visitor; it stands for a while, and then goes from point to point.

    Args:
        start: where it begins.
        points: of the round; straight ways between them are clear, and from `start` to the first.

    Attributes:
        place: where the visitor is.
        walked: metres that it has walked.
    """

    def __init__(self, start: Place, points: tuple[Point, ...]) -> None:
        self.place = start
        self.walked = 0.0
        self._points = points
        self._next = 0
        self._waits = _PAUSE

    def advance(self, seconds: float, robot: Point) -> None:
        """Let time pass; `robot` is where the robot is."""
        if self._waits > 0:
            self._waits -= seconds
            return
        x, y = self._points[self._next]
        dx, dy = x - self.place.x, y - self.place.y
        left = hypot(dx, dy)
        step = _SPEED * seconds
        if left <= step:
            self._next = (self._next + 1) % len(self._points)
            self._waits = _PAUSE
            self.place = Place(x, y, self.place.th)
            return
        ahead = (robot[0] - self.place.x) * dx + (robot[1] - self.place.y) * dy > 0
        if ahead and dist((self.place.x, self.place.y), robot) < _APART:
            return
        self.walked += step
        self.place = Place(self.place.x + dx / left * step, self.place.y + dy / left * step, atan2(dy, dx))
