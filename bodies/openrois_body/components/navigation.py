"""Navigation: the body walks to places, one after another, round all obstacles (component 13)."""

from collections.abc import Callable
from math import atan2
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from openrois.adapter import BadParameter, ComponentFailed, components, parameter
from openrois_body.components.moving import Moving
from openrois_body.messages import MAX_PATH, Floor, Place, Thing, Waypoint
from openrois_body.motion.legs import Motion
from openrois_body.motion.planning import SPEED, NoWay
from openrois_body.motion.targets import Position, read_targets

__all__ = ["Navigation"]

_NEAR: Final = 0.8
"""Metres from a person or thing at which the figure has reached it."""
_TRIES: Final = 3
"""Number of times that the game engine may abort a walk before a target is reached."""
_BETWEEN_TRIES: Final = 0.5


class Navigation(Moving, components.Navigation):
    """Walks to `target_positions` in turn: `x,y` or `x,y,th`, or the ref or name of a person or thing.

    Args:
        figure: walks.
    """

    time_limit: Annotated[int, Field(ge=0)] = parameter(0)
    routing_policy: Literal["time", "distance"] = parameter("time")

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse targets that are neither positions nor in the scene."""
        targets = changes.get("target_positions")
        if targets is not None:
            read_targets(targets, self.figure.world)
        return changes

    async def start(self) -> None:
        """Walk to the last target."""
        targets = self.target_positions
        if not targets:
            raise BadParameter("target_positions is not set; set it before start")
        read_targets(targets, self.figure.world)
        async with self.moving(self.time_limit) as motion:
            leave = self.figure.world.changed.add(
                lambda change: self.replan(motion) if isinstance(change, Floor) else None
            )
            try:
                await self._visit(motion, targets)
            finally:
                leave()

    async def _visit(self, motion: Motion, targets: tuple[str, ...]) -> None:
        tour, tries = _Tour(targets, self.reached_target), 0
        while tour.left:
            await self.going()
            path, tour.ends = await self._route(tour.left)
            if self.is_suspended:
                continue
            before = len(tour.left)
            ended = await motion.walk(path, SPEED, tour.reached)
            if ended == "OK":
                tour.reached(len(path) - 1)
            tries = 0 if len(tour.left) < before else tries + (ended == "ABORT")
            if tries == _TRIES:
                raise ComponentFailed(f"{tour.left[0]!r}: the body broke the motion off {_TRIES} times")
            if ended == "ABORT":
                await self.figure.rest(_BETWEEN_TRIES)

    async def _route(self, targets: tuple[str, ...]) -> tuple[list[Waypoint], list[int]]:
        """Return the path through the targets, at most `MAX_PATH` points, and the indices of its targets."""
        while True:
            floor = self.figure.world.floor
            path, ends = await self._through(targets)
            if floor is self.figure.world.floor:
                return path[:MAX_PATH], [end for end in ends if end < MAX_PATH]

    async def _through(self, targets: tuple[str, ...]) -> tuple[list[Waypoint], list[int]]:
        at = self.figure.place()
        path: list[Waypoint] = []
        ends: list[int] = []
        for text, target in zip(targets, read_targets(targets, self.figure.world), strict=True):
            try:
                part = await self._part(at, target)
            except NoWay as error:
                raise NoWay(f"{text!r} {error}") from error
            path += part
            ends.append(len(path) - 1)
            at = _end_of(at, part)
        return path, ends

    async def _part(self, at: Place, target: Position | Thing) -> list[Waypoint]:
        if isinstance(target, Position):
            return await self.figure.ways.to(at, target, self.routing_policy)
        way = await self.figure.ways.to_within(at, target, _NEAR, self.routing_policy)
        end = _end_of(at, way)
        return [*way, Waypoint(end.x, end.y, atan2(target.y - end.y, target.x - end.x))]


class _Tour:
    """The targets that are left, while walks lead through them."""

    def __init__(self, targets: tuple[str, ...], on_reached: Callable[[str, bool], None]) -> None:
        self.left = targets
        self.ends: list[int] = []
        self._on_reached = on_reached

    def reached(self, index: int) -> None:
        """Note that the figure has reached the point of the path with this index."""
        while self.ends and self.ends[0] <= index:
            del self.ends[0]
            target, *rest = self.left
            self.left = tuple(rest)
            self._on_reached(target, not rest)


def _end_of(start: Place, path: list[Waypoint]) -> Place:
    """Return where the figure is at the end of a path, and its direction there."""
    at = start
    for point in path:
        th = point.th
        if th is None:
            th = atan2(point.y - at.y, point.x - at.x) if (point.x, point.y) != (at.x, at.y) else at.th
        at = Place(point.x, point.y, th)
    return at
