"""The way from one place to another round all obstacles: the shortest, or the fastest. Pure.

A shortest way bends at corners only, so it is searched for in the visibility graph of `Ground.bends` (A*), which is
made as far as the search gets and kept. The fastest is searched for among the ways that hug corners like the shortest
ones, with the turns as part of what they cost.
"""

from heapq import heappop, heappush
from itertools import count, pairwise
from math import atan2, hypot, pi
from typing import Final, Literal, TypeAlias

import numpy as np

from openrois.errors import ComponentFailed
from openrois_body.motion.ground import Ground, Numbers

__all__ = ["SPEED", "TURN_TIME", "NoWay", "Point", "Policy", "angle", "length", "plan", "seconds"]

Point: TypeAlias = tuple[float, float]
Policy: TypeAlias = Literal["distance", "time"]

SPEED: Final = 1.0
"""Metres a second at which the figure walks unless another speed is given."""
TURN_TIME: Final = 2 / pi
"""Seconds that a turn by one radian costs: a right angle takes one second, as long as a metre."""
_MOST_STEPS: Final = 20_000
"""Steps of the search for the fastest way, after which the shortest is taken."""

_START: Final = -1
_GOAL: Final = -2


class NoWay(ComponentFailed):
    """A place that cannot be reached; the text says why, as in "is outside of the floor"."""


def plan(ground: Ground | None, start: Point, heading: float, goal: Point, policy: Policy) -> list[Point]:
    """Return the points of a way after `start`, up to and with `goal`.

    A figure that stands too near an obstacle goes straight to the nearest clear point at first.

    Args:
        ground: the obstacles; None without any.
        start: where the figure is.
        heading: its direction, in radians.
        goal: where the way leads.
        policy: minimise `distance` or `time`.

    Raises:
        NoWay: the goal cannot be reached.
    """
    if ground is None:
        return [goal]
    clear = ground.nearest_clear(np.asarray(start))
    if clear is None:
        raise NoWay("cannot be reached: the body has no room on this floor")
    check(ground, goal)
    search = _Search(ground, clear, np.asarray(goal), heading)
    found = (search.fastest() if policy == "time" else None) or search.shortest()
    if found is None:
        raise NoWay("cannot be reached: obstacles are all around it, or around the body")
    way = [(float(x), float(y)) for x, y in found]
    return way if np.array_equal(clear, start) else [(float(clear[0]), float(clear[1])), *way]


def check(ground: Ground, goal: Point) -> None:
    """Check that the figure can stand at a place.

    Raises:
        NoWay: it cannot stand there; the text says why.
    """
    point = np.asarray([goal])
    if ground.clear(point)[0]:
        return
    if not ground.inside(point)[0]:
        raise NoWay("is outside of the floor or inside an obstacle")
    raise NoWay(f"is only {ground.distances(point)[0]:.2f} m from an edge; the body needs {ground.radius:.2f} m")


def length(start: Point, way: list[Point]) -> float:
    """Return the metres of a way."""
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise([start, *way]))


def seconds(start: Point, heading: float, way: list[Point]) -> float:
    """Return the estimated seconds of a way: its length at `SPEED`, and `TURN_TIME` for each radian."""
    turned = 0.0
    for a, b in pairwise([start, *way]):
        if a != b:
            towards = atan2(b[1] - a[1], b[0] - a[0])
            turned += angle(heading, towards)
            heading = towards
    return length(start, way) / SPEED + turned * TURN_TIME


def angle(one: float, other: float) -> float:
    """Return the radians between two directions, from 0 to pi."""
    return abs((other - one + pi) % (2 * pi) - pi)


class _Search:
    """One search from a clear point to another; its nodes are the ground's bends, start and goal."""

    def __init__(self, ground: Ground, start: Numbers, goal: Numbers, heading: float) -> None:
        self._ground = ground
        self._start = start
        self._goal = goal
        self._heading = heading
        self._last = {int(bend) for bend in ground.reachable(goal)}

    def shortest(self) -> list[Numbers] | None:
        """Return the shortest way, by A*."""
        order = count()
        came_from = {_START: _START}
        gone = {_START: 0.0}
        heap = [(0.0, next(order), _START)]
        done: set[int] = set()
        while heap:
            _, _, node = heappop(heap)
            if node == _GOAL:
                return self._way(came_from, node)
            if node in done:
                continue
            done.add(node)
            for bend, far in self._steps(node):
                so_far = gone[node] + far
                if so_far < gone.get(bend, float("inf")):
                    gone[bend], came_from[bend] = so_far, node
                    heappush(heap, (so_far + self._left(bend), next(order), bend))
        return None

    def fastest(self) -> list[Numbers] | None:
        """A* over nodes with the direction in which they are reached; None also where it would take too long.

        An arrival at a node is dropped if another arrival there, turned into the same direction, is no later.
        """
        order = count()
        arrivals: dict[int, list[tuple[float, float]]] = {}
        heap: list[tuple[float, int, float, float, tuple[int, ...]]] = [
            (0.0, next(order), 0.0, self._heading, (_START,))
        ]
        for _ in range(_MOST_STEPS):
            if not heap:
                return None
            _, _, spent, heading, path = heappop(heap)
            node = path[-1]
            if node == _GOAL:
                return [self._at(each) for each in path[1:]]
            if any(spent >= sooner + angle(heading, other) * TURN_TIME for sooner, other in arrivals.get(node, ())):
                continue
            arrivals.setdefault(node, []).append((spent, heading))
            here = self._at(node)
            for bend, far in self._steps(node):
                there = self._at(bend)
                towards = atan2(there[1] - here[1], there[0] - here[0]) if far else heading
                cost = spent + far / SPEED + angle(heading, towards) * TURN_TIME
                heappush(heap, (cost + self._time_left(bend, towards), next(order), cost, towards, (*path, bend)))
        return None

    def _steps(self, node: int) -> list[tuple[int, float]]:
        """Return the nodes that can follow a node, and how far away they are."""
        if node == _START:
            bends = self._ground.reachable(self._start)
            away = self._ground.bends[bends] - self._start
            far = np.hypot(away[:, 0], away[:, 1])
            last = bool(self._ground.open(self._start, self._goal[None])[0])
        else:
            bends, far = self._ground.neighbours(node)
            last = node in self._last
        steps = list(zip(bends.tolist(), far.tolist(), strict=True))
        return [*steps, (_GOAL, self._left(node))] if last else steps

    def _left(self, node: int) -> float:
        at = self._at(node)
        return float(np.hypot(at[0] - self._goal[0], at[1] - self._goal[1]))

    def _time_left(self, node: int, heading: float) -> float:
        """Return a lower bound of the cost: a way to the goal turns into its direction at some point."""
        left = self._left(node)
        if not left:
            return 0.0
        at = self._at(node)
        return left / SPEED + angle(heading, atan2(self._goal[1] - at[1], self._goal[0] - at[0])) * TURN_TIME

    def _at(self, node: int) -> Numbers:
        if node == _START:
            return self._start
        return self._goal if node == _GOAL else np.asarray(self._ground.bends[node])

    def _way(self, came_from: dict[int, int], node: int) -> list[Numbers]:
        way = []
        while node != _START:
            way.append(self._at(node))
            node = came_from[node]
        return way[::-1]
