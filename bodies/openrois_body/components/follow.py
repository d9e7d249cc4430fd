"""Follow: the body stays near a person or thing that moves (component 14)."""

import asyncio
from math import atan2, dist
from typing import Annotated, Any, Final

from pydantic import Field

from openrois.adapter import BadParameter, ComponentFailed, components, parameter
from openrois.aio.tasks import TaskScope
from openrois_body.components.moving import Figure, Moving
from openrois_body.messages import MAX_PATH, Floor, Place, Thing, Things, Waypoint
from openrois_body.motion.legs import Motion
from openrois_body.motion.planning import NoWay, angle, length

__all__ = ["Follow"]

_SPEED: Final = 1.5
"""Metres a second: faster than most people walk."""
_APART: Final = 0.6
"""Metres from middle to middle that two bodies need: the least distance, whatever `distance` says."""
_WORTH_GOING: Final = 0.1
"""Metres: a shorter way is not worth a step."""
_WORTH_TURNING: Final = 0.5
"""Radians by which the target may leave the middle of its sight while it stands."""
_MOVED: Final = 0.15
"""Metres by which the target may move before the way is planned again."""
_GONE: Final = 5.0
"""Seconds for which the target may be gone, or out of reach."""
_TRIES: Final = 3
_BETWEEN_TRIES: Final = 0.5
_MILLIMETRE: Final = 0.001


class Follow(Moving, components.Follow):
    """Keeps within `distance` of what `target_object_ref` names, until `stop`.

    Args:
        figure: walks.
    """

    distance: Annotated[int, Field(ge=0, le=100_000)] | None = parameter(None)
    time_limit: Annotated[int, Field(ge=0)] | None = parameter(None)

    def __init__(self, figure: Figure) -> None:
        super().__init__(figure)
        self._news = asyncio.Event()
        self._followed: Thing | None = None

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse a target that is not in the scene."""
        target = changes.get("target_object_ref")
        if target is not None:
            self.figure.world.find(target)
        return changes

    async def start(self) -> None:
        """Follow until `stop`, a time limit or a failure."""
        if self.target_object_ref is None or self.distance is None:
            raise BadParameter("set target_object_ref and distance first")
        thing_id = self.figure.world.find(self.target_object_ref).id
        async with self.moving(self.time_limit) as motion:
            leave = self.figure.world.changed.add(lambda change: self._on_world_changed(motion, change))
            try:
                await self._follow(motion, thing_id, self.distance * _MILLIMETRE)
            finally:
                leave()
                self._followed = None

    async def _follow(self, motion: Motion, thing_id: str, metres: float) -> None:
        tries = 0
        missed_since: float | None = None
        while True:
            await self.going()
            self._news.clear()
            path, why = await self._path(thing_id, metres)
            if self.is_suspended:
                continue
            if why:
                motion.halt()
                missed_since = self._clock.now() if missed_since is None else missed_since
                if self._clock.now() >= missed_since + _GONE:
                    raise ComponentFailed(f"{self.name}: {self.target_object_ref!r} {why}, for {_GONE:g} s")
                await self._wait(missed_since + _GONE)
                continue
            missed_since = None
            if not path:
                motion.halt()
                await self._news.wait()
                continue
            ended = await motion.walk(path[:MAX_PATH], _SPEED)
            tries = tries + 1 if ended == "ABORT" else 0
            if tries == _TRIES:
                raise ComponentFailed(f"{self.name}: the body broke the motion off {_TRIES} times")
            if tries:
                await self.figure.rest(_BETWEEN_TRIES)

    async def _path(self, thing_id: str, metres: float) -> tuple[list[Waypoint], str]:
        """Return the path to walk now, empty to stand still; or why there is none."""
        thing = self._find(thing_id)
        self._followed = thing
        if thing is None:
            return [], "is not in the scene"
        place = self.figure.place()
        try:
            near = max(metres, _APART) if thing.kind == "person" else metres
            way = await self.figure.ways.to_within(place, thing, near, "distance")
        except NoWay as error:
            return [], str(error)
        points = [(at.x, at.y) for at in way]
        at = (place.x, place.y)
        if length(at, points) >= _WORTH_GOING:
            x, y = points[-1]
            return [*way, Waypoint(x, y, _towards((x, y), thing, place.th))], ""
        towards = _towards(at, thing, place.th)
        if angle(place.th, towards) >= _WORTH_TURNING:
            return [Waypoint(*at, towards)], ""
        return [], ""

    async def _wait(self, deadline: float) -> None:
        """Wait for news, or for the deadline."""
        async with TaskScope() as tasks:
            tasks.start(self._ring(deadline))
            await self._news.wait()

    async def _ring(self, deadline: float) -> None:
        await self._clock.sleep_until(deadline)
        self._news.set()

    def _on_world_changed(self, motion: Motion, change: Place | Floor | Things | None) -> None:
        self._news.set()
        if isinstance(change, Floor):
            self.replan(motion)
        elif isinstance(change, Things) and self._has_moved():
            motion.interrupt()

    def _has_moved(self) -> bool:
        old = self._followed
        new = None if old is None else self._find(old.id)
        return old is None or new is None or dist((old.x, old.y), (new.x, new.y)) > _MOVED

    def _find(self, thing_id: str) -> Thing | None:
        return next((thing for thing in self.figure.world.things if thing.id == thing_id), None)


def _towards(at: tuple[float, float], thing: Thing, otherwise: float) -> float:
    """Return the direction of a thing; `otherwise` where the figure stands in it."""
    return atan2(thing.y - at[1], thing.x - at[0]) if dist(at, (thing.x, thing.y)) > _WORTH_GOING else otherwise
