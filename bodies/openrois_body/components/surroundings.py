"""Surroundings: the floor, and everything on it, as needed to draw a map. A component of OpenRoIS."""

import asyncio
from collections.abc import Callable
from typing import Final

from openrois_streaming.clock import MediaClock

from openrois.adapter import Component, ComponentStatus, Payload, event, query
from openrois.aio.tasks import TaskScope
from openrois_body.messages import Floor, Place, Point, Things
from openrois_body.motion.world import World
from openrois_body.sensing.changes import Place as Position

__all__ = ["Surroundings"]

_PLACES: Final = 0.05
_CHANGES: Final = 0.1
"""Seconds between two events on the figure's place, and on anything else, however often the engine reports."""


class FloorResult(Payload):
    """The floor on which the body can go: corners `x,y` in metres. Without an outline there are no limits."""

    outline: tuple[str, ...]
    obstacles: tuple[tuple[str, ...], ...]


class ThingsResult(Payload):
    """The things of the scene as parallel lists: refs, kinds (person, object, sound), names, places `x,y,th`."""

    thing_ref: tuple[str, ...]
    kind: tuple[str, ...]
    name: tuple[str, ...]
    position_data: tuple[str, ...]


class Surroundings(Component, authority="OpenRoIS", function="sensing"):
    """Announces changes of the scene around the body.

    Args:
        world: the scene.
        clock: the media clock.
        engine_status: returns the status of the game engine.
    """

    def __init__(self, world: World, clock: MediaClock, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__()
        self._world = world
        self._clock = clock
        self._engine_status = engine_status
        self._moved, self._other_floor, self._other_things = asyncio.Event(), asyncio.Event(), asyncio.Event()
        self._scope = TaskScope()
        world.changed.add(self._on_world_changed)

    def condition(self) -> ComponentStatus:
        """Return the status of the game engine."""
        return self._engine_status()

    async def connect(self) -> None:
        """Start to announce changes."""
        self._scope = TaskScope()
        await self._scope.__aenter__()
        self._scope.start(self._announce_changes(self._moved, _PLACES, self._announce_place))
        self._scope.start(self._announce_changes(self._other_floor, _CHANGES, self.floor_changed))
        self._scope.start(self._announce_changes(self._other_things, _CHANGES, self.things_changed))

    async def disconnect(self) -> None:
        """Stop announcing changes."""
        await self._scope.__aexit__(None, None, None)

    @query
    async def floor(self) -> FloorResult:
        """Return where the body can go."""
        floor = self._world.floor
        if floor is None:
            return FloorResult(outline=(), obstacles=())
        return FloorResult(outline=_texts(floor.outline), obstacles=tuple(map(_texts, floor.obstacles)))

    @query
    async def things(self) -> ThingsResult:
        """Return the things of the scene beside the body."""
        things = self._world.things
        return ThingsResult(
            thing_ref=tuple(map(self._world.ref, things)),
            kind=tuple(thing.kind for thing in things),
            name=tuple(thing.name for thing in things),
            position_data=tuple(Position(thing.x, thing.y, thing.th).text for thing in things),
        )

    @event
    def figure_moved(self, position_data: str) -> None:
        """The body is somewhere else: `x,y,th`; up to 20 times a second.

        Args:
            position_data: where it is
        """

    @event
    def floor_changed(self) -> None:
        """`floor` answers something else; up to 10 times a second."""

    @event
    def things_changed(self) -> None:
        """`things` answers something else; up to 10 times a second."""

    def _on_world_changed(self, change: Place | Floor | Things | None) -> None:
        if isinstance(change, Place):
            self._moved.set()
        if isinstance(change, Floor | None):
            self._other_floor.set()
        if isinstance(change, Things | None):
            self._other_things.set()

    async def _announce_changes(self, news: asyncio.Event, seconds: float, announce: Callable[[], None]) -> None:
        """Announce a change at once, and the next ones at intervals of so many seconds."""
        while True:
            await news.wait()
            news.clear()
            announce()
            await self._clock.sleep_until(self._clock.now() + seconds)

    def _announce_place(self) -> None:
        if (place := self._world.place) is not None:
            self.figure_moved(Position(place.x, place.y, place.th).text)


def _texts(corners: tuple[Point, ...]) -> tuple[str, ...]:
    return tuple(f"{x:.3f},{y:.3f}" for x, y in corners)
