"""Surroundings: the floor, and everything on it, as needed to draw a map. A component of our own."""

from collections.abc import Callable

from openrois.adapter import Component, ComponentStatus, Payload, event, query
from openrois_avatar.link.messages import Floor, Place, Things
from openrois_avatar.link.messages.motion import Point
from openrois_avatar.sensing.changes import Place as Position
from openrois_avatar.world import World

__all__ = ["Surroundings"]


class FloorResult(Payload):
    """Where the figure can go: corners `x,y` in metres. Without an outline there are no limits."""

    outline: tuple[str, ...]
    obstacles: tuple[tuple[str, ...], ...]


class ThingsResult(Payload):
    """What there is beside the figure, side by side: refs, kinds (person, object, sound), names, places `x,y,th`."""

    thing_ref: tuple[str, ...]
    kind: tuple[str, ...]
    name: tuple[str, ...]
    position_data: tuple[str, ...]


class Surroundings(Component, authority="OpenRoIS", function="sensing"):
    """Tells what the game engine has told of its scene.

    Args:
        world: the scene.
        engine_status: tells whether the game engine works now.
    """

    def __init__(self, world: World, engine_status: Callable[[], ComponentStatus]) -> None:
        super().__init__("Surroundings")
        self._world = world
        self._engine_status = engine_status
        world.changed.add(self._tell)

    def condition(self) -> ComponentStatus:
        """Follow the game engine."""
        return self._engine_status()

    @query
    async def floor(self) -> FloorResult:
        """Return where the figure can go."""
        floor = self._world.floor
        if floor is None:
            return FloorResult(outline=(), obstacles=())
        return FloorResult(outline=_texts(floor.outline), obstacles=tuple(map(_texts, floor.obstacles)))

    @query
    async def things(self) -> ThingsResult:
        """Return what there is beside the figure."""
        things = self._world.things
        return ThingsResult(
            thing_ref=tuple(map(self._world.ref, things)),
            kind=tuple(thing.kind for thing in things),
            name=tuple(thing.name for thing in things),
            position_data=tuple(Position(thing.x, thing.y, thing.th).text for thing in things),
        )

    @event
    def figure_moved(self, position_data: str) -> None:
        """The figure is somewhere else: `x,y,th`; up to 20 times a second.

        Args:
            position_data: where it is
        """

    @event
    def floor_changed(self) -> None:
        """`floor` answers something else."""

    @event
    def things_changed(self) -> None:
        """`things` answers something else; up to 10 times a second."""

    def _tell(self, change: Place | Floor | Things | None) -> None:
        if isinstance(change, Place):
            self.figure_moved(Position(change.x, change.y, change.th).text)
        if isinstance(change, Floor | None):
            self.floor_changed()
        if isinstance(change, Things | None):
            self.things_changed()


def _texts(corners: tuple[Point, ...]) -> tuple[str, ...]:
    return tuple(f"{x:.3f},{y:.3f}" for x, y in corners)
