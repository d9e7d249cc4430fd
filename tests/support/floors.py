"""Random floors, and the clearance of a way, computed point by point, independently of the tested code."""

from collections.abc import Sequence
from itertools import pairwise
from math import cos, dist, hypot, pi, sin

from hypothesis import strategies as st
from openrois_body.messages import Floor

Point = tuple[float, float]
ROOM = 6.0
"""Half the side of the room around every random floor, in metres."""


def rectangle(left: float, low: float, right: float, high: float) -> tuple[Point, ...]:
    return (left, low), (right, low), (right, high), (left, high)


SQUARE = rectangle(-ROOM, -ROOM, ROOM, ROOM)


@st.composite
def polygons(draw: st.DrawFn) -> tuple[Point, ...]:
    """A star around a point: simple, often not convex, either way round."""
    x, y = draw(st.tuples(coordinates(ROOM), coordinates(ROOM)))
    reaches = draw(st.lists(st.floats(0.2, 2.0), min_size=3, max_size=7))
    corners = [
        (x + reach * cos(2 * pi * turn / len(reaches)), y + reach * sin(2 * pi * turn / len(reaches)))
        for turn, reach in enumerate(reaches)
    ]
    return tuple(corners if draw(st.booleans()) else corners[::-1])


def coordinates(most: float = ROOM - 0.3) -> st.SearchStrategy[float]:
    return st.floats(-most, most, allow_subnormal=False)


def points() -> st.SearchStrategy[Point]:
    return st.tuples(coordinates(), coordinates())


def floors(most: int = 4) -> st.SearchStrategy[Floor]:
    return st.builds(Floor, st.just(SQUARE), st.lists(polygons(), max_size=most).map(tuple))


def is_inside(polygon: Sequence[Point], point: Point) -> bool:
    """By the number of edges on the way out to the right."""
    inside = False
    for (ax, ay), (bx, by) in pairwise([*polygon, polygon[0]]):
        if (ay > point[1]) != (by > point[1]) and point[0] < ax + (point[1] - ay) * (bx - ax) / (by - ay):
            inside = not inside
    return inside


def edges(floor: Floor) -> list[tuple[Point, Point]]:
    return [pair for polygon in (floor.outline, *floor.obstacles) for pair in pairwise([*polygon, polygon[0]])]


def from_edge(point: Point, edge: tuple[Point, Point]) -> float:
    (ax, ay), (bx, by) = edge
    square = (bx - ax) ** 2 + (by - ay) ** 2
    share = ((point[0] - ax) * (bx - ax) + (point[1] - ay) * (by - ay)) / square if square else 0.0
    share = min(1.0, max(0.0, share))
    return hypot(point[0] - ax - share * (bx - ax), point[1] - ay - share * (by - ay))


def room_at(floor: Floor, point: Point) -> float:
    """The metres from a point to the nearest edge; -1 outside of the floor."""
    if not is_inside(floor.outline, point) or any(is_inside(each, point) for each in floor.obstacles):
        return -1.0
    return min(from_edge(point, edge) for edge in edges(floor))


def room_along(floor: Floor, way: Sequence[Point], step: float = 0.02) -> float:
    """The least room at any point of a way."""
    least = room_at(floor, way[0])
    for a, b in pairwise(way):
        parts = max(1, int(dist(a, b) / step))
        for part in range(1, parts + 1):
            share = part / parts
            least = min(least, room_at(floor, (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))))
    return least


def metres(way: Sequence[Point]) -> float:
    return sum(dist(a, b) for a, b in pairwise(way))
