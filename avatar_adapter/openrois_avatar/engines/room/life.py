"""The life of the room: commands go in with their time, scenes and events come out."""

from collections.abc import Mapping
from math import hypot
from typing import Final, Generic, TypeVar

from openrois_body.messages.motion import Point

from openrois_avatar.engines.animation.gait import Steps
from openrois_avatar.engines.room.plan import HOME, RADIO, ROOM
from openrois_avatar.engines.room.scene import OtherFigure, Scene
from openrois_avatar.engines.room.shot import VIEWPOINTS, Camerawork
from openrois_avatar.engines.room.visitor import Visitor
from openrois_avatar.engines.room.walking import Walker, turned
from openrois_avatar.link.messages import Completed, Drive, Event, Halt, Place, Thing, Things, Walk

_PLACES: Final = 1 / 20
_THINGS: Final = 1 / 10
"""Seconds between two reports, at least."""
_EARSHOT: Final = 2.0
"""Metres within which the radio is heard."""
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
        """Whether it speaks or reacts, and whether it still has to turn to the viewer for that."""
        self._floor_is_told = False
        self._places: _Reports[Place] = _Reports(_PLACES)
        self._things: _Reports[tuple[Thing, ...]] = _Reports(_THINGS)

    @property
    def walking(self) -> Mapping[str, float]:
        """The offsets of the figure's steps, by channel of a pose."""
        return self._steps.channels()

    def obey(self, time: float, command: Walk | Drive | Halt) -> None:
        """Apply a command to the figure from this time on."""
        self._walker.advance(time, self._crowd)
        # A walking figure turns at the end of its walk, unless the walk ends with a direction.
        self._addressing &= isinstance(command, Walk) and command.path[-1].th is None
        if isinstance(command, Walk):
            self._walker.walk(command)
        elif isinstance(command, Drive):
            self._walker.drive(time, command)
        else:
            self._walker.halt()

    def stay(self) -> None:
        """Stop turning to the viewer after an interruption; a walk and a drive go on."""
        self._addressing = False
        self._walker.stay()

    def show_from(self, viewpoint: str) -> None:
        """Choose one of `VIEWPOINTS`; another name changes nothing."""
        if viewpoint in VIEWPOINTS:
            self._camera.viewpoint = viewpoint

    def advance(self, time: float, expressive: bool) -> Scene:
        """Advance to a time and return the scene. `expressive`: whether the figure speaks or reacts."""
        seconds, self._time = time - self._time, time
        self._walker.advance(time, self._crowd)
        self._address(expressive)
        pace = self._walker.pace
        self._steps.advance(pace.ahead, pace.left, pace.turn, seconds)
        shot = self._camera.follow(time, self._walker.place, self._walker.pace, expressive)
        return Scene(self._walker.place, self._advance_visitor(time, seconds), shot)

    def _advance_visitor(self, time: float, seconds: float) -> OtherFigure | None:
        if self._visitor is None:
            return None
        self._visitor.advance(time, self._walker.place)
        pace = self._visitor.pace
        self._visitors.advance(pace.ahead, pace.left, pace.turn, seconds)
        return OtherFigure(self._visitor.place, self._visitors.channels())

    def _address(self, expressive: bool) -> None:
        """Turn to the viewer when the figure begins to speak or react with its back or side to the viewer."""
        self._addressing = expressive and (self._addressing or not self._expressive)
        self._expressive = expressive
        if self._walker.is_driven:
            # After a lost operator it stands, and does not begin to turn by itself.
            self._addressing = False
        if self._addressing and not self._walker.is_walking:
            self._addressing = False
            if abs(turned(self._walker.place.th - HOME.th)) > _ASIDE:
                self._walker.turn(HOME.th)

    @property
    def radio(self) -> float:
        """The nearness of the radio to the figure, 0 (not heard) to 1."""
        place = self._walker.place
        return min(max((_EARSHOT - hypot(RADIO.x - place.x, RADIO.y - place.y)) / _EARSHOT / 0.7, 0.0), 1.0)

    @property
    def _crowd(self) -> tuple[Point, ...]:
        return () if self._visitor is None else ((self._visitor.place.x, self._visitor.place.y),)

    def news(self) -> list[Event]:
        """Return the events at the time of the last advance."""
        events: list[Event] = []
        if not self._floor_is_told:
            self._floor_is_told = True
            events.append(ROOM.floor)
        things = ROOM.things if self._visitor is None else (*ROOM.things, self._visitor.thing)
        if self._things.is_due(self._time, things):
            events.append(Things(things))
        done = self._walker.news()
        place = self._walker.place
        # The place is sent with the end of a walk.
        is_over = any(isinstance(event, Completed) for event in done)
        if self._places.is_due(self._time, place, at_once=is_over):
            events.append(place)
        return [*events, *done]


class _Reports(Generic[_Value]):
    """Decides when a changed value is reported, which is not too often."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._told: _Value | None = None
        self._time = float("-inf")

    def is_due(self, time: float, value: _Value, at_once: bool = False) -> bool:
        """Return whether to report this value now, and note it as reported."""
        if value == self._told or not (at_once or time - self._time >= self._period - _NEARLY):
            return False
        self._told, self._time = value, time
        return True
