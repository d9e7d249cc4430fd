"""The home of the simulated robot: its map, the locations and shelves that it knows, and the persons in it. Pure."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from math import ceil, hypot
from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["HOUSE", "House", "Location", "Person", "Pose", "Shelf"]

_RADIUS: Final = 0.2
"""Metres that the middle of the robot keeps from what stands there."""
_STEP: Final = 0.05
"""Metres between two points of a way that are looked at."""


@dataclass(frozen=True, slots=True)
class Pose:
    """A pose in the frame of the map: metres, and radians to the left."""

    x: float
    y: float
    th: float = 0.0


@dataclass(frozen=True, slots=True)
class Box:
    """A rectangle on the floor, in metres."""

    left: float
    bottom: float
    right: float
    top: float

    def is_within(self, x: float, y: float, margin: float) -> bool:
        """Tell whether a point is in it, or as near as `margin`."""
        return self.left - margin < x < self.right + margin and self.bottom - margin < y < self.top + margin


@dataclass(frozen=True, slots=True)
class Location:
    """A location that has a name."""

    id: str
    name: str
    pose: Pose
    is_charger: bool = False
    is_shelf_home: bool = False


@dataclass(frozen=True, slots=True)
class Shelf:
    """A shelf, which stands at its home at first."""

    id: str
    name: str
    home: str


@dataclass(frozen=True, slots=True)
class Person:
    """A person who stands there."""

    x: float
    y: float


@dataclass(frozen=True, slots=True)
class House:
    """A home.

    Attributes:
        outline: the floor.
        furniture: what stands on it.
        locations: with names; the first is the charger.
        shelves: that the robot can carry.
        persons: who are there.
        corners: points round which the robot drives.
        resolution: metres of a pixel of the map.
    """

    outline: Box
    furniture: tuple[Box, ...]
    locations: tuple[Location, ...]
    shelves: tuple[Shelf, ...]
    persons: tuple[Person, ...]
    corners: tuple[Pose, ...]
    resolution: float = 0.05

    def is_free(self, x: float, y: float) -> bool:
        """Tell whether the robot can stand there."""
        floor = self.outline
        is_inside = floor.is_within(x, y, -_RADIUS)
        return is_inside and not any(box.is_within(x, y, _RADIUS) for box in self.furniture)

    def is_clear(self, start: Pose, end: Pose) -> bool:
        """Tell whether the robot can go straight from one place to another."""
        away = hypot(end.x - start.x, end.y - start.y)
        parts = max(1, ceil(away / _STEP))
        return all(
            self.is_free(start.x + (end.x - start.x) * part / parts, start.y + (end.y - start.y) * part / parts)
            for part in range(1, parts + 1)
        )

    def route(self, start: Pose, end: Pose) -> tuple[Pose, ...]:
        """Return the points of a way, the last of which is the end; none where there is no way."""
        if self.is_clear(start, end):
            return (end,)
        ways = [way for way in self._round(start, end) if _is_clear_way(self, start, way)]
        return min(ways, key=lambda way: _length(start, way), default=())

    def _round(self, start: Pose, end: Pose) -> Iterator[tuple[Pose, ...]]:
        for first in self.corners:
            yield first, end
            for second in self.corners:
                yield first, second, end

    @property
    def origin(self) -> Pose:
        """The corner of the map at the bottom on the left."""
        return Pose(self.outline.left, self.outline.bottom)

    @cache  # noqa: B019 - houses are few, and live as long as the process
    def grid(self) -> NDArray[np.uint8]:
        """Return the map from above, its top row first: 255 is floor, 0 is taken."""
        floor = self.outline
        rows = round((floor.top - floor.bottom) / self.resolution)
        columns = round((floor.right - floor.left) / self.resolution)
        pixels = np.full((rows, columns), 255, np.uint8)
        for box in self.furniture:
            top, bottom = (round((floor.top - y) / self.resolution) for y in (box.top, box.bottom))
            left, right = (round((x - floor.left) / self.resolution) for x in (box.left, box.right))
            pixels[top:bottom, left:right] = 0
        pixels[[0, -1], :] = pixels[:, [0, -1]] = 0
        return pixels


def _is_clear_way(house: House, start: Pose, way: tuple[Pose, ...]) -> bool:
    return all(house.is_clear(one, next_one) for one, next_one in zip((start, *way), way, strict=False))


def _length(start: Pose, way: tuple[Pose, ...]) -> float:
    return sum(hypot(b.x - a.x, b.y - a.y) for a, b in zip((start, *way), way, strict=False))


HOUSE: Final = House(
    outline=Box(-0.5, -2.5, 6.5, 2.5),
    furniture=(Box(3.2, -0.5, 4.0, 0.5), Box(6.0, -2.5, 6.5, -1.0)),
    locations=(
        Location("L00", "charger", Pose(0.0, 0.0), is_charger=True),
        Location("L01", "kitchen", Pose(5.5, 1.5, 0.0)),
        Location("L02", "sofa", Pose(4.5, -1.8, -1.57)),
        Location("L03", "tea corner", Pose(1.2, 1.8, 1.57), is_shelf_home=True),
        Location("L04", "library", Pose(2.6, 1.8, 1.57), is_shelf_home=True),
        Location("L05", "entrance", Pose(1.0, -1.8, 3.14)),
    ),
    shelves=(Shelf("S01", "tea shelf", "L03"), Shelf("S02", "book shelf", "L04")),
    persons=(Person(2.4, 0.2), Person(5.8, 2.1)),
    corners=(Pose(2.8, 0.9), Pose(2.8, -0.9), Pose(4.4, 0.9), Pose(4.4, -0.9)),
)
"""The home of the simulated robot, in whose frame its charger is at 0, 0."""
