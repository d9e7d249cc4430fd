"""The life of the room: commands go in with their time, scenes and events come out."""

from collections.abc import Mapping
from math import hypot
from typing import Final, Generic, TypeVar

from openrois_avatar.engines.animation.gait import Steps
from openrois_avatar.engines.room.plan import HOME, RADIO, ROOM
from openrois_avatar.engines.room.scene import Scene, Somebody
from openrois_avatar.engines.room.shot import VIEWPOINTS, Camerawork
from openrois_avatar.engines.room.visitor import Visitor
from openrois_avatar.engines.room.walking import Walker, turned
from openrois_avatar.link.messages import Completed, Drive, Event, Halt, Place, Thing, Things, Walk
from openrois_avatar.link.messages.motion import Point

_PLACES: Final = 1 / 20
_THINGS: Final = 1 / 10
"""Seconds between two reports, at least."""
_EARSHOT: Final = 2.0
"""Metres from which the radio is heard."""
_ASIDE: Final = 0.35
"""Radians by which a figure faces past the viewer before it turns to speak."""
_NEARLY: Final = 1e-6

_Value = TypeVar("_Value")


class Life:
    """The figure in the room, with a visitor or alone. Times are seconds on one clock and never go back."""

    def __init__(self, time: float, seed: int = 1, *, visited: bool = False) -> None:
        self._time = time
        self._walker = Walker(ROOM, HOME, time)
        self._visitor = Visitor(ROOM, time, seed) if visited else None
        self._steps, self._visitors = Steps(), Steps()
        self._camera = Camerawork(time)
        self._expressive = self._addressing = False
        """Whether it says something with face or hands, and whether it is still to turn to the viewer for that."""
        self._floor_is_told = False
        self._places: _Reports[Place] = _Reports(_PLACES)
        self._things: _Reports[tuple[Thing, ...]] = _Reports(_THINGS)

    @property
    def walking(self) -> Mapping[str, float]:
        """What the figure's steps add to its body, by channel of a pose."""
        return self._steps.channels()

    def obey(self, time: float, command: Walk | Drive | Halt) -> None:
        """Let the figure go or stand from this time on."""
        self._walker.advance(time, self._crowd)
        # One that walks somewhere turns when it is there, unless it was told where to face.
        self._addressing &= isinstance(command, Walk) and command.path[-1].th is None
        if isinstance(command, Walk):
            self._walker.walk(command)
        elif isinstance(command, Drive):
            self._walker.drive(time, command)
        else:
            self._walker.halt()

    def stay(self) -> None:
        """Turn to the viewer no more, for what it said was broken off; a walk and a drive go on."""
        self._addressing = False
        self._walker.stay()

    def show_from(self, viewpoint: str) -> None:
        """Show the room from one of `VIEWPOINTS`; another name changes nothing."""
        if viewpoint in VIEWPOINTS:
            self._camera.viewpoint = viewpoint

    def advance(self, time: float, expressive: bool) -> Scene:
        """Go on until a time; what is to be seen then. `expressive`: whether its face or hands say something."""
        seconds, self._time = time - self._time, time
        self._walker.advance(time, self._crowd)
        self._address(expressive)
        pace = self._walker.pace
        self._steps.take(pace.ahead, pace.left, pace.turn, seconds)
        shot = self._camera.follow(time, self._walker.place, self._walker.pace, expressive)
        return Scene(self._walker.place, self._advance_visitor(time, seconds), shot)

    def _advance_visitor(self, time: float, seconds: float) -> Somebody | None:
        if self._visitor is None:
            return None
        self._visitor.advance(time, self._walker.place)
        pace = self._visitor.pace
        self._visitors.take(pace.ahead, pace.left, pace.turn, seconds)
        return Somebody(self._visitor.place, self._visitors.channels())

    def _address(self, expressive: bool) -> None:
        """Turn to the viewer when it begins to say something with its back or its side to that viewer."""
        self._addressing = expressive and (self._addressing or not self._expressive)
        self._expressive = expressive
        if self._walker.is_driven:
            # Where the hand is lost it stands, and does not begin to turn by itself.
            self._addressing = False
        if self._addressing and not self._walker.is_walking:
            self._addressing = False
            if abs(turned(self._walker.place.th - HOME.th)) > _ASIDE:
                self._walker.turn(HOME.th)

    @property
    def radio(self) -> float:
        """How near the radio is to the figure, 0 (not heard) to 1."""
        place = self._walker.place
        return min(max((_EARSHOT - hypot(RADIO.x - place.x, RADIO.y - place.y)) / _EARSHOT / 0.7, 0.0), 1.0)

    @property
    def _crowd(self) -> tuple[Point, ...]:
        return () if self._visitor is None else ((self._visitor.place.x, self._visitor.place.y),)

    def news(self) -> list[Event]:
        """What is to be told at the time that was last advanced to."""
        events: list[Event] = []
        if not self._floor_is_told:
            self._floor_is_told = True
            events.append(ROOM.floor)
        things = ROOM.things if self._visitor is None else (*ROOM.things, self._visitor.thing)
        if self._things.is_due(self._time, things):
            events.append(Things(things))
        done = self._walker.news()
        place = self._walker.place
        # Who hears that a walk is over shall know where.
        is_over = any(isinstance(event, Completed) for event in done)
        if self._places.is_due(self._time, place, at_once=is_over):
            events.append(place)
        return [*events, *done]


class _Reports(Generic[_Value]):
    """Tells of a value when it has changed, and not too often."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._told: _Value | None = None
        self._time = float("-inf")

    def is_due(self, time: float, value: _Value, at_once: bool = False) -> bool:
        """Whether to tell of this value now; it counts as told then."""
        if value == self._told or not (at_once or time - self._time >= self._period - _NEARLY):
            return False
        self._told, self._time = value, time
        return True
