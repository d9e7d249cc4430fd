"""The visitor: a figure that walks slowly from place to place in the room, and stays a while at each."""

from collections.abc import Sequence
from math import hypot
from typing import Final

import numpy as np
from openrois_body.messages.motion import Point

from openrois_avatar.engines.room.plan import HOME, Plan, to_edge
from openrois_avatar.engines.room.walking import APART, RADIUS, STANDING, Pace, Walker
from openrois_avatar.link.messages import Place, Thing, Walk, Waypoint

PLACES: Final[Sequence[Waypoint]] = (
    Waypoint(2.5, 0.9, 2.6),
    Waypoint(2.65, 2.2, -2.6),
    Waypoint(2.3, 3.3, -2.0),
    Waypoint(-1.9, 3.4, -1.2),
    Waypoint(-2.4, 1.7, -0.2),
)
"""Its places and directions there: outside of the background of the close view."""
_SPEED: Final = 0.6
_STAY: Final = (5.0, 12.0)
"""Shortest and longest stay, in seconds."""
_PATIENCE: Final = 2.0
"""Seconds for which it waits for another figure in its way."""
_NOTICE: Final = APART + 0.15
"""Metres at which it makes room for another figure."""
_LOOK: Final = 0.1
"""Seconds between two looks around."""
_HOME_RADIUS: Final = 0.8
"""Metres that it keeps from the figure's first place."""


class Visitor:
    """A visitor on a plan; one seed gives one sequence of walks, as long as no figure is in its way."""

    def __init__(self, plan: Plan, time: float, seed: int = 1) -> None:
        self._plan, self._random = plan, np.random.default_rng(seed)
        first = PLACES[0]
        assert first.th is not None
        self._walker = Walker(plan, Place(first.x, first.y, first.th), time)
        self._time = time
        self._leave = time + self._random.uniform(*_STAY)
        self._waited = 0.0

    @property
    def place(self) -> Place:
        """The present place."""
        return self._walker.place

    @property
    def pace(self) -> Pace:
        """The present pace."""
        return self._walker.pace

    @property
    def thing(self) -> Thing:
        """The visitor as a thing of the engine link."""
        place = self.place
        return Thing("visitor", "person", place.x, place.y, place.th, "visitor")

    def advance(self, time: float, other: Place) -> None:
        """Advance to a time, with another figure at a place."""
        there = (other.x, other.y)
        while self._time + _LOOK <= time:
            self._time += _LOOK
            self._walker.advance(self._time, (there,))
            self._think(there)
        self._walker.advance(time, (there,))

    def _think(self, other: Point) -> None:
        """Decide whether to go on or stay."""
        place, pace = self._walker.place, self._walker.pace
        if self._walker.news():
            self._leave = self._time + self._random.uniform(*_STAY)
        if self._walker.is_walking:
            self._waited = self._waited + _LOOK if pace == STANDING else 0.0
            if self._waited >= _PATIENCE:
                self._go_on(other)
        elif self._time >= self._leave or hypot(other[0] - place.x, other[1] - place.y) < _NOTICE:
            self._go_on(other)

    def _go_on(self, other: Point) -> None:
        """Walk to another place, if one can be reached."""
        self._waited, self._leave = 0.0, self._time + _PATIENCE
        places = [place for place in PLACES if self._is_way(place, other)]
        if places:
            self._walker.walk(Walk("visit", (places[self._random.integers(len(places))],), _SPEED))

    def _is_way(self, goal: Waypoint, other: Point) -> bool:
        """Return whether the straight way is clear of furniture, the figure's first place, and close figures."""
        here = self._walker.place
        start, end = (here.x, here.y), (goal.x, goal.y)
        length = hypot(end[0] - start[0], end[1] - start[1])
        if length < APART or to_edge(HOME.x, HOME.y, start, end) < _HOME_RADIUS:
            return False
        return to_edge(*other, start, end) >= min(APART, hypot(other[0] - start[0], other[1] - start[1])) and (
            self._plan.is_clear(start, end, RADIUS)
        )
