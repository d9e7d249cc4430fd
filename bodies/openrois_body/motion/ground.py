"""A floor for a round body: which points and straight ways are clear, and at which corners ways bend. Pure.

Nothing of a polygon is moved outwards: a way is clear where no edge comes nearer than the radius. So it does not matter
which way round a polygon is written, whether polygons overlap, or whether one crosses itself (then it is inside where
the number of its edges on the way out is odd).
"""

from math import ceil, cos, pi
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from openrois_body.messages import Floor

__all__ = ["MARGIN", "Ground", "Numbers", "Truths"]

Numbers: TypeAlias = NDArray[np.float64]
Truths: TypeAlias = NDArray[np.bool_]

MARGIN: Final = 0.005
"""Metres beyond the radius at which ways pass corners, so that rounding does not matter."""
_ARC: Final = pi / 3
"""The most that a way bends at one point; a sharper corner is passed over several."""
_SAME: Final = 1e-9
_AT_ONCE: Final = 256
"""Points that are compared with all edges at once: it takes about 100 kB for each."""
_TINY: Final = 0.001
"""Metres: the size of an obstacle without extent."""


class Ground:
    """A floor and a body on it.

    Args:
        floor: outline and obstacles.
        radius: of the body, in metres.

    Attributes:
        bends: the points, of shape (n, 2), at which the shortest ways bend; all are clear.
    """

    def __init__(self, floor: Floor, radius: float) -> None:
        polygons = [_without_repeats(polygon) for polygon in (floor.outline, *floor.obstacles)]
        self.radius = radius
        self._corners = np.concatenate(polygons)
        self._next = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons])
        self._edges = self._next - self._corners
        self._first = np.cumsum([0, *(len(polygon) for polygon in polygons[:-1])])
        self._after = np.concatenate(
            [first + np.roll(np.arange(len(each)), -1) for first, each in zip(self._first, polygons, strict=True)]
        )
        bends = [_bends(polygon, radius + MARGIN) for polygon in polygons]
        points, tangents = (np.concatenate(parts) for parts in zip(*bends, strict=True))
        clear = self.clear(points)
        self.bends: Numbers = points[clear]
        self._tangents: Numbers = tangents[clear]
        self._neighbours: dict[int, tuple[NDArray[np.intp], Numbers]] = {}

    def inside(self, points: Numbers) -> Truths:
        """Return which points (n, 2) are inside the outline and outside of all obstacles."""
        within = self._within(points)
        return np.asarray(within[:, 0] & ~within[:, 1:].any(axis=1))

    def distances(self, points: Numbers) -> Numbers:
        """Return how far points (n, 2) are from the next edge."""
        found = np.empty(len(points))
        for first in range(0, len(points), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            away = self._feet(points[some]) - points[some, None]
            found[some] = np.hypot(away[..., 0], away[..., 1]).min(axis=1)
        return found

    def clear(self, points: Numbers) -> Truths:
        """Return at which points (n, 2) the body can stand."""
        return self.inside(points) & (self.distances(points) >= self.radius)

    def clear_at(self, point: tuple[float, float]) -> bool:
        """Return whether the body can stand at one point."""
        return bool(self.clear(np.asarray([point]))[0])

    def open(self, start: Numbers, ends: Numbers) -> Truths:
        """Return to which clear points (n, 2) the body can go straight from a clear point (2,)."""
        way = ends - start
        length = np.hypot(way[:, :1], way[:, 1:])
        way = way / np.maximum(length, _SAME)
        corners = self._corners - start
        # Each edge's corner, measured along the way and across it: an edge is too near only where it is crossed, or
        # where one of its corners is too near, for both ends of the way are clear.
        across = way[:, :1] * corners[:, 1] - way[:, 1:] * corners[:, 0]
        along = way @ corners.T
        near = (np.abs(across) < self.radius) & (along > 0) & (along < length)
        # A way without length is open, whatever rounding says.
        return ~np.asarray((near | self._crossed(across, start, ends)).any(axis=1)) | (length[:, 0] < _SAME)

    def sees(self, start: Numbers, ends: Numbers) -> Truths:
        """Return which points (n, 2) are in sight of a point (2,): no edge is in between, however near.

        An obstacle that a point is in does not hide it: furniture is a thing and, around its middle, an obstacle.
        """
        way = ends - start
        corners = self._corners - start
        across = way[:, :1] * corners[:, 1] - way[:, 1:] * corners[:, 0]
        hiding = np.logical_or.reduceat(self._crossed(across, start, ends), self._first, axis=1)
        hiding[:, 1:] &= ~self._within(ends)[:, 1:]
        return ~np.asarray(hiding.any(axis=1))

    def nearest_clear(self, point: Numbers) -> Numbers | None:
        """Return the clear point (2,) that is nearest to a point (2,); None without any.

        It is exact where one edge is too near, and an upper bound where several are.
        """
        if self.clear(point[None])[0]:
            return point
        feet = self._feet(point[None])[0]
        out = point - feet
        length = np.hypot(out[:, 0], out[:, 1])[:, None]
        normal = np.stack([-self._edges[:, 1], self._edges[:, 0]], axis=1)
        normal = normal / np.maximum(np.hypot(normal[:, 0], normal[:, 1]), _SAME)[:, None]
        out = np.where(length > _SAME, out / np.maximum(length, _SAME), normal)
        # A point in an obstacle leaves it beyond the edge, any other one on its own side of the edge.
        reach = out * (self.radius + MARGIN)
        candidates = np.concatenate([feet + reach, feet - reach, self.bends])
        candidates = candidates[self.clear(candidates)]
        if not len(candidates):
            return None
        away = np.hypot(candidates[:, 0] - point[0], candidates[:, 1] - point[1])
        return np.asarray(candidates[np.argmin(away)])

    def reachable(self, start: Numbers) -> NDArray[np.intp]:
        """Return the indices of the bends to which a way from a clear point (2,) can lead at first."""
        chosen = np.flatnonzero(self._touches(start, np.arange(len(self.bends))))
        return chosen[self.open(start, self.bends[chosen])]

    def neighbours(self, bend: int) -> tuple[NDArray[np.intp], Numbers]:
        """Return the indices of the bends that can follow a bend on a way, and how far away each is."""
        known = self._neighbours.get(bend)
        if known is None:
            at = self.bends[bend]
            others = np.arange(len(self.bends))
            chosen = others[self._touches(at, others) & self._leaves(bend, self.bends) & (others != bend)]
            chosen = chosen[self.open(at, self.bends[chosen])]
            known = chosen, np.hypot(self.bends[chosen, 0] - at[0], self.bends[chosen, 1] - at[1])
            self._neighbours[bend] = known
        return known

    def _within(self, points: Numbers) -> Truths:
        """Return in which polygons (n, polygons), the outline first, points (n, 2) are."""
        x, y = points[:, :1], points[:, 1:]
        starts_above, ends_above = self._corners[:, 1] > y, self._next[:, 1] > y
        with np.errstate(divide="ignore", invalid="ignore"):
            at = self._corners[:, 0] + (y - self._corners[:, 1]) * self._edges[:, 0] / self._edges[:, 1]
        crossed = (starts_above != ends_above) & (x < at)
        return np.asarray(np.add.reduceat(crossed, self._first, axis=1, dtype=np.intp) % 2 == 1)

    def _touches(self, start: Numbers, bends: NDArray[np.intp]) -> Truths:
        """Return which bends are passed, not run into, on a way from `start`: others are on no shortest way."""
        way = start - self.bends[bends]
        return _supports(way, self._tangents[bends])

    def _leaves(self, bend: int, ends: Numbers) -> Truths:
        return _supports(ends - self.bends[bend], self._tangents[bend][None])

    def _feet(self, points: Numbers) -> Numbers:
        """Return the points of all edges, (n, edges, 2), that are nearest to each point."""
        squares = np.maximum((self._edges**2).sum(axis=1), _SAME**2)
        away = points[:, None] - self._corners
        share = np.clip((away * self._edges).sum(axis=2) / squares, 0.0, 1.0)
        return np.asarray(self._corners + share[..., None] * self._edges)

    def _crossed(self, across: Numbers, start: Numbers, ends: Numbers) -> Truths:
        """Return which edges (n, edges) lie across the ways, given on which side of each way its corner lies."""
        on_left = across < 0
        normals = np.stack([-self._edges[:, 1], self._edges[:, 0]])
        lines = (self._corners * normals.T).sum(axis=1)
        start_left, ends_left = start @ normals > lines, ends @ normals > lines
        return np.asarray((on_left != on_left[:, self._after]) & (start_left != ends_left))


def _without_repeats(polygon: tuple[tuple[float, float], ...]) -> Numbers:
    """Return corners (n, 2) without repetitions; a mere point becomes a tiny triangle."""
    corners = np.asarray(polygon, dtype=np.float64)
    moves = np.abs(corners - np.roll(corners, 1, axis=0)).max(axis=1) > _SAME
    return corners[moves] if moves.any() else corners[:1] + _TINY * np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])


def _bends(corners: Numbers, radius: float) -> tuple[Numbers, Numbers]:
    """Return where a taut string bends that keeps `radius` from a polygon's corners, on their outer sides.

    Returns:
        Points (n, 2), and at each the directions (n, 2, 2) of the string before and after it.
    """
    points: list[tuple[float, float]] = []
    tangents: list[tuple[tuple[float, float], tuple[float, float]]] = []
    edges = np.roll(corners, -1, axis=0) - corners
    headings = np.arctan2(edges[:, 1], edges[:, 0])
    for index, (x, y) in enumerate(corners):
        before, turn = headings[index - 1], float(headings[index] - headings[index - 1])
        turn = (turn + pi) % (2 * pi) - pi
        parts = ceil(abs(turn) / _ARC - _SAME)
        outwards = -pi / 2 if turn > 0 else pi / 2
        for part in range(parts):
            first, last = before + turn * part / parts, before + turn * (part + 1) / parts
            middle = (first + last) / 2 + outwards
            reach = radius / cos(turn / parts / 2)
            points.append((x + reach * np.cos(middle), y + reach * np.sin(middle)))
            tangents.append(((np.cos(first), np.sin(first)), (np.cos(last), np.sin(last))))
    return np.asarray(points).reshape(-1, 2), np.asarray(tangents).reshape(-1, 2, 2)


def _supports(way: Numbers, tangents: Numbers) -> Truths:
    """Return where a string in the direction `way` leaves the corner that it touches on one side."""
    before = way[:, 1] * tangents[:, 0, 0] - way[:, 0] * tangents[:, 0, 1]
    after = way[:, 0] * tangents[:, 1, 1] - way[:, 1] * tangents[:, 1, 0]
    return np.asarray(before * after >= -_SAME)
