"""The way to a place that is near a target and in sight of it; and the check of a given path. Pure."""

from itertools import pairwise
from math import ceil, dist
from typing import Final

import numpy as np

from openrois.errors import ComponentFailed
from openrois_body.messages import Floor
from openrois_body.motion.ground import Ground
from openrois_body.motion.planning import NoWay, Point, Policy, plan

__all__ = ["approach", "check_path"]

_LOOK: Final = 0.1
"""Metres between two points of a way at which the sight of the target is checked."""
_HALVINGS: Final = 8
_FINE: Final = 0.005
"""Metres: less room than this counts as none."""


def approach(
    ground: Ground | None, start: Point, heading: float, centre: Point, metres: float, policy: Policy
) -> list[Point]:
    """Return the points of the way to a place that is within `metres` of `centre` and in sight of it.

    It is empty where that is so at the start. Where there is no room at that distance, for the centre is in an obstacle
    or too near one, it ends at the clear point next to it.

    Raises:
        NoWay: it cannot be reached; the text says why.
    """
    if _is_near(ground, start, centre, metres):
        return []
    goal = centre
    if ground is not None:
        clear = ground.nearest_clear(np.asarray(centre))
        if clear is None:
            raise NoWay("cannot be reached: the body has no room on this floor")
        goal = float(clear[0]), float(clear[1])
    way: list[Point] = []
    for at, point in pairwise([start, *plan(ground, start, heading, goal, policy)]):
        parts = max(1, ceil(dist(at, point) / _LOOK))
        for part in range(1, parts + 1):
            if _is_near(ground, _between(at, point, part / parts), centre, metres):
                return [*way, _first_near(ground, at, point, ((part - 1) / parts, part / parts), centre, metres)]
        way.append(point)
    return way


def check_path(floor: Floor, ground: Ground, start: Point, path: list[Point]) -> None:
    """Check that a path is clear all along.

    A figure that stands too near something may go wherever it does not come nearer.

    Args:
        floor: the floor of `ground`.
        ground: of the body's radius.
        start: where the figure is.
        path: the points that it goes to straight, one after another.

    Raises:
        ComponentFailed: an obstacle is in the way; the text says after how many metres.
    """
    if not ground.clear_at(start):
        at = np.asarray([start])
        room = float(ground.distances(at)[0]) - _FINE if ground.inside(at)[0] else 0.0
        if room <= 0:
            raise ComponentFailed("the body stands in an obstacle, or outside of the floor")
        ground = Ground(floor, room)
    gone = 0.0
    for here, end in pairwise([start, *path]):
        share = _open_share(ground, here, end)
        gone += share * dist(here, end)
        if share < 1:
            raise ComponentFailed(f"an obstacle is in the way after {gone:.2f} m")


def _is_near(ground: Ground | None, at: Point, centre: Point, metres: float) -> bool:
    if dist(at, centre) > metres:
        return False
    return ground is None or bool(ground.sees(np.asarray(at), np.asarray([centre]))[0])


def _first_near(
    ground: Ground | None, start: Point, end: Point, shares: tuple[float, float], centre: Point, metres: float
) -> Point:
    """Return where on a straight way the centre gets near, between a share where it is not and one where it is."""
    far, near = shares
    for _ in range(_HALVINGS):
        middle = (far + near) / 2
        if _is_near(ground, _between(start, end, middle), centre, metres):
            near = middle
        else:
            far = middle
    return _between(start, end, near)


def _open_share(ground: Ground, start: Point, end: Point) -> float:
    """Return the share of a straight way that is open, from 0 to 1."""
    if _is_open(ground, start, end):
        return 1.0
    is_open, closed = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = (is_open + closed) / 2
        if _is_open(ground, start, _between(start, end, middle)):
            is_open = middle
        else:
            closed = middle
    return is_open


def _is_open(ground: Ground, start: Point, end: Point) -> bool:
    return ground.clear_at(end) and bool(ground.open(np.asarray(start), np.asarray([end]))[0])


def _between(start: Point, end: Point, share: float) -> Point:
    return start[0] + (end[0] - start[0]) * share, start[1] + (end[1] - start[1]) * share
