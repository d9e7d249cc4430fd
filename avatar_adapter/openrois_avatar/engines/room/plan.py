"""The plan of the room: floor, furniture, and the space for a body."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import cos, hypot, pi, sin
from typing import Final

from openrois_body.messages.motion import Point

from openrois_avatar.link.messages import Floor, Place, Thing

HOME: Final = Place(0.0, 0.0, -pi / 2)
"""The first place of the figure, facing the viewer."""
_STEP: Final = 0.05
"""Metres between the checked points of a way."""


def box(x: float, y: float, width: float, depth: float) -> tuple[Point, ...]:
    """Return the corners of a rectangle around a point, counter-clockwise."""
    right, back = width / 2, depth / 2
    return ((x - right, y - back), (x + right, y - back), (x + right, y + back), (x - right, y + back))


def round_(x: float, y: float, radius: float, corners: int = 8) -> tuple[Point, ...]:
    """Return the corners of a regular polygon around a circle, outside of it, counter-clockwise."""
    turns = [(number + 0.5) * 2 * pi / corners for number in range(corners)]
    out = radius / cos(pi / corners)
    return tuple((round(x + out * cos(turn), 3), round(y + out * sin(turn), 3)) for turn in turns)


@dataclass(frozen=True, slots=True)
class Furniture:
    """A piece of furniture: name, middle, outline, and height, in metres."""

    name: str
    x: float
    y: float
    outline: tuple[Point, ...]
    height: float

    @property
    def reach(self) -> float:
        """The largest distance of a corner from the middle, in metres."""
        return max(hypot(x - self.x, y - self.y) for x, y in self.outline)


# High pieces stand where no figure can be behind them, and all outside of the close view of `HOME`.
TABLE: Final = Furniture("table", 1.6, 2.2, box(1.6, 2.2, 1.3, 0.7), 0.74)
PILLAR: Final = Furniture("pillar", 1.95, 3.8, box(1.95, 3.8, 0.4, 0.4), 2.6)
PLANT: Final = Furniture("plant", -2.5, 3.5, round_(-2.5, 3.5, 0.28), 1.45)
STOOL: Final = Furniture("stool", -2.2, 0.5, round_(-2.2, 0.5, 0.24), 0.46)
RADIO: Final = Thing("radio", "sound", 1.9, 2.25, -pi / 2, "radio")
"""The radio on the table, which plays."""


class Plan:
    """A floor with furniture on it."""

    def __init__(
        self, outline: tuple[Point, ...], furniture: Sequence[Furniture], others: Sequence[Thing] = ()
    ) -> None:
        self.outline, self.furniture = outline, tuple(furniture)
        self._others = tuple(others)
        self._reaches = tuple(piece.reach for piece in self.furniture)

    @property
    def floor(self) -> Floor:
        """The floor as a message of the engine link."""
        return Floor(self.outline, tuple(piece.outline for piece in self.furniture))

    @property
    def things(self) -> tuple[Thing, ...]:
        """All things that never move."""
        pieces = (Thing(piece.name, "object", piece.x, piece.y, 0.0, piece.name) for piece in self.furniture)
        return (*pieces, *self._others)

    def fits(self, x: float, y: float, radius: float) -> bool:
        """Return whether a round body of this radius fits there."""
        if not _inside(x, y, self.outline) or _distance(x, y, self.outline) < radius:
            return False
        near = (
            piece.outline
            for piece, reach in zip(self.furniture, self._reaches, strict=True)
            if hypot(x - piece.x, y - piece.y) < reach + radius
        )
        return not any(_inside(x, y, outline) or _distance(x, y, outline) < radius for outline in near)

    def is_clear(self, start: Point, end: Point, radius: float) -> bool:
        """Return whether a round body of this radius can go straight from one point to another."""
        length = hypot(end[0] - start[0], end[1] - start[1])
        count = max(1, round(length / _STEP))
        shares = [number / count for number in range(count + 1)]
        return all(
            self.fits(start[0] + (end[0] - start[0]) * share, start[1] + (end[1] - start[1]) * share, radius)
            for share in shares
        )


ROOM: Final = Plan(box(0.0, 1.5, 6.0, 5.0), (TABLE, PILLAR, PLANT, STOOL), (RADIO,))
"""The room: 6 m wide, from 1 m in front of where the figure begins to 4 m behind."""


def _inside(x: float, y: float, polygon: Sequence[Point]) -> bool:
    """Return whether a point is inside: a ray to the right crosses the polygon an odd number of times."""
    odd = False
    for (ax, ay), (bx, by) in pairwise((*polygon, polygon[0])):
        if (ay > y) != (by > y) and x < ax + (bx - ax) * (y - ay) / (by - ay):
            odd = not odd
    return odd


def _distance(x: float, y: float, polygon: Sequence[Point]) -> float:
    """Return the distance of a point from the polygon's edge, in metres."""
    return min(to_edge(x, y, start, end) for start, end in pairwise((*polygon, polygon[0])))


def to_edge(x: float, y: float, start: Point, end: Point) -> float:
    """Return the distance of a point from the line segment between two others, in metres."""
    (ax, ay), (bx, by) = start, end
    across, up = bx - ax, by - ay
    share = min(max(((x - ax) * across + (y - ay) * up) / (across * across + up * up), 0.0), 1.0)
    return hypot(x - ax - share * across, y - ay - share * up)
