"""Ways over the current floor of the scene; long planning is done in a thread beside the event loop."""

import asyncio
from collections.abc import Callable
from typing import Final, TypeVar

from openrois_body.messages import Floor, Place, Thing, Waypoint
from openrois_body.motion.approach import approach, check_path
from openrois_body.motion.ground import Ground
from openrois_body.motion.planning import NoWay, Policy, plan
from openrois_body.motion.targets import Position
from openrois_body.motion.world import World

__all__ = ["BODY", "Ways"]

BODY: Final = 0.25
"""Metres around the middle of the figure that have to be free."""
_SMALL: Final = 40
"""Corners of a floor up to which planning takes no longer than handing it to a thread."""

_TRIES: Final = 5
"""Attempts at a way when the floor changes during planning."""

_Found = TypeVar("_Found")


class Ways:
    """Plans ways in the current world; what was computed about a floor is kept until the next floor.

    Args:
        world: what is known of the scene.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._known: tuple[Floor | None, Ground | None] = None, None

    @property
    def are_quick(self) -> bool:
        """Whether planning on the current floor takes a moment only."""
        return _is_small(self._world.floor)

    async def to(self, start: Place, target: Position, policy: Policy) -> list[Waypoint]:
        """Return the way to a position, with a turn at its end where the position has a direction.

        Raises:
            NoWay: it cannot be reached; the text says why.
        """
        at, goal = (start.x, start.y), (target.x, target.y)
        points = await self._on_ground(lambda ground: plan(ground, at, start.th, goal, policy))
        way = [Waypoint(x, y) for x, y in points]
        return way if target.th is None else [*way, Waypoint(*goal, target.th)]

    async def to_within(self, start: Place, thing: Thing, metres: float, policy: Policy) -> list[Waypoint]:
        """Return the way to within `metres` of a thing, in sight of it; empty where the figure is near enough.

        Raises:
            NoWay: it cannot be reached; the text says why.
        """
        at, centre = (start.x, start.y), (thing.x, thing.y)
        points = await self._on_ground(lambda ground: approach(ground, at, start.th, centre, metres, policy))
        return [Waypoint(x, y) for x, y in points]

    async def check(self, start: Place, path: list[Waypoint]) -> None:
        """Check that a path is clear all along.

        Raises:
            ComponentFailed: an obstacle is in the way; the text says after how many metres.
        """
        floor, points = self._world.floor, [(at.x, at.y) for at in path]
        if floor is not None:
            await self._on_ground(
                lambda ground: None if ground is None else check_path(floor, ground, (start.x, start.y), points)
            )

    async def _on_ground(self, work: Callable[[Ground | None], _Found]) -> _Found:
        """Run `work` with the current floor; again if the floor has changed meanwhile, `_TRIES` times in all.

        Raises:
            NoWay: as `work`, or the floor has changed each time.
        """
        for _ in range(_TRIES):
            floor = self._world.floor
            if _is_small(floor):
                found = work(self._ground(floor))
            else:
                found = await asyncio.to_thread(lambda on: work(self._ground(on)), floor)
            if floor is self._world.floor:
                return found
        raise NoWay("cannot be reached: the floor changes faster than a way is planned; try again later")

    def _ground(self, floor: Floor | None) -> Ground | None:
        known, ground = self._known
        if known is not floor:
            ground = None if floor is None else Ground(floor, BODY)
            self._known = floor, ground
        return ground


def _is_small(floor: Floor | None) -> bool:
    return floor is None or len(floor.outline) + sum(map(len, floor.obstacles)) <= _SMALL
