"""Place and motion of the figure, and the scene around it.

Coordinates are metres and radians seen from above: x to the right and y away from the viewer of the picture, angles
counter-clockwise from the x axis. The figure begins at 0, 0 and faces the viewer, at -pi/2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any, Final, Literal, TypeAlias

from openrois_body.messages.reading import MAX_NAME, LinkError, integer, real, text

MAX_PATH: Final = 1_000
"""Most points of a path or a polygon: as many as surely fit 64 KiB."""
MAX_OBSTACLES: Final = 100
MAX_CORNERS: Final = 1_000
"""Most obstacles of a floor, and most corners that its outline and obstacles have together."""
MAX_THINGS: Final = 100
FAR: Final = 10_000.0
"""Largest coordinate, in metres."""
MAX_SPEED: Final = 10.0
"""Fastest that the figure can be asked to go, in metres a second; and to turn, in radians a second."""

Point: TypeAlias = tuple[float, float]
Kind: TypeAlias = Literal["person", "object", "sound"]
_KINDS: Final[Mapping[str, Kind]] = {"person": "person", "object": "object", "sound": "sound"}


def _array(value: Any, name: str, most: int) -> Sequence[Any]:
    if not isinstance(value, list) or len(value) > most:
        raise LinkError(f"{name}: expected an array of at most {most} items")
    return value


def _point(value: Any, name: str) -> Point:
    x, y = _numbers(value, name, 2)
    return _coordinate(x, name), _coordinate(y, name)


def _numbers(value: Any, name: str, count: int) -> Sequence[Any]:
    if not isinstance(value, list) or len(value) != count:
        raise LinkError(f"{name}: expected arrays of {count}")
    return value


def _coordinate(value: Any, name: str) -> float:
    return real(value, name, -FAR, FAR)


def _angle(value: Any, name: str) -> float:
    return real(value, name, -2 * pi, 2 * pi)


def _polygon(value: Any, name: str) -> tuple[Point, ...]:
    corners = tuple(_point(item, name) for item in _array(value, name, MAX_CORNERS))
    if len(corners) < 3:
        raise LinkError(f"{name}: expected at least three corners")
    return corners


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A point of a path, reached facing `th`, or along the way where that is None."""

    x: float
    y: float
    th: float | None = None

    @classmethod
    def from_json(cls, item: Any) -> Waypoint:
        """Read `[x, y, th]`."""
        x, y, th = _numbers(item, "path", 3)
        return cls(_coordinate(x, "path"), _coordinate(y, "path"), None if th is None else _angle(th, "path"))


@dataclass(frozen=True, slots=True)
class Walk:
    """Go from where the figure stands straight to each point in turn, at `speed` metres a second.

    A waypoint with `th` is reached facing that way; one where the figure stands is a turn on the spot. The engine
    answers with `Reached` for each waypoint, and one `Completed` of this id: OK at the last one, ABORT when another
    `Walk`, a `Drive` or `Halt` ended it before. It does not look for a way round obstacles; the adapter did.
    """

    id: str
    path: tuple[Waypoint, ...]
    speed: float

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        path = [[round(at.x, 4), round(at.y, 4), None if at.th is None else round(at.th, 5)] for at in self.path]
        return {"command": "walk", "id": self.id, "path": path, "speed": self.speed}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Walk:
        """Read the body of COMMAND."""
        path = tuple(Waypoint.from_json(item) for item in _array(body.get("path"), "path", MAX_PATH))
        if not path:
            raise LinkError("path: expected at least one point")
        return cls(text(body, "id", MAX_NAME), path, real(body.get("speed"), "speed", 0.01, MAX_SPEED))


@dataclass(frozen=True, slots=True)
class Drive:
    """Go with this velocity: metres a second ahead and to the left, radians a second to the left.

    It holds until the next one, and for 0.5 s at most: a driver repeats it, and a lost driver leaves a figure that
    stands. It ends a `Walk`.
    """

    ahead: float
    left: float
    turn: float

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "drive", "ahead": self.ahead, "left": self.left, "turn": self.turn}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Drive:
        """Read the body of COMMAND."""
        ahead, left, turn = (real(body.get(name), name, -MAX_SPEED, MAX_SPEED) for name in ("ahead", "left", "turn"))
        return cls(ahead, left, turn)


@dataclass(frozen=True, slots=True)
class Halt:
    """Stand still now; a walk or drive ends."""

    def to_json(self) -> dict[str, Any]:
        """The body of COMMAND."""
        return {"command": "halt"}

    @classmethod
    def from_json(cls, _body: Mapping[str, Any]) -> Halt:
        """Read the body of COMMAND."""
        return cls()


@dataclass(frozen=True, slots=True)
class Reached:
    """The figure has reached the waypoint with this index of the walk with this id."""

    id: str
    index: int

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT."""
        return {"event": "reached", "id": self.id, "index": self.index}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Reached:
        """Read the body of EVENT."""
        return cls(text(body, "id", MAX_NAME), integer(body, "index", 0, MAX_PATH - 1))


@dataclass(frozen=True, slots=True)
class Place:
    """The figure's place; sent after the greeting and while it moves, at most 20 times a second."""

    x: float
    y: float
    th: float

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT."""
        return {"event": "place", "x": round(self.x, 4), "y": round(self.y, 4), "th": round(self.th, 5)}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Place:
        """Read the body of EVENT."""
        x, y = _coordinate(body.get("x"), "x"), _coordinate(body.get("y"), "y")
        return cls(x, y, _angle(body.get("th"), "th"))


@dataclass(frozen=True, slots=True)
class Floor:
    """The floor on which the figure can go: inside the outline and outside of all obstacles. Replaces the last one."""

    outline: tuple[Point, ...]
    obstacles: tuple[tuple[Point, ...], ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT."""
        obstacles = [[list(corner) for corner in obstacle] for obstacle in self.obstacles]
        return {"event": "floor", "outline": [list(corner) for corner in self.outline], "obstacles": obstacles}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Floor:
        """Read the body of EVENT."""
        obstacles = _array(body.get("obstacles"), "obstacles", MAX_OBSTACLES)
        floor = cls(_polygon(body.get("outline"), "outline"), tuple(_polygon(item, "obstacles") for item in obstacles))
        if len(floor.outline) + sum(map(len, floor.obstacles)) > MAX_CORNERS:
            raise LinkError(f"obstacles: more than {MAX_CORNERS} corners with the outline")
        return floor


@dataclass(frozen=True, slots=True)
class Thing:
    """A person, an object or a source of sound in the scene; `id` names it as long as the engine lives."""

    id: str
    kind: Kind
    x: float
    y: float
    th: float = 0.0
    name: str = ""

    def to_json(self) -> dict[str, Any]:
        """One item of `things`."""
        x, y, th = round(self.x, 4), round(self.y, 4), round(self.th, 5)
        return {"id": self.id, "kind": self.kind, "name": self.name, "x": x, "y": y, "th": th}

    @classmethod
    def from_json(cls, item: Any) -> Thing:
        """Read one item of `things`; `th` and `name` may be missing."""
        if not isinstance(item, dict):
            raise LinkError("things: expected an array of objects")
        kind = _KINDS.get(text(item, "kind", MAX_NAME))
        if kind is None:
            raise LinkError(f"kind: expected one of {', '.join(_KINDS)}")
        x, y = _coordinate(item.get("x"), "x"), _coordinate(item.get("y"), "y")
        name = text(item, "name", MAX_NAME) if "name" in item else ""
        return cls(text(item, "id", MAX_NAME), kind, x, y, _angle(item.get("th", 0.0), "th"), name)


@dataclass(frozen=True, slots=True)
class Things:
    """All things of the scene beside the figure; sent when one changes, at most 10 times a second."""

    things: tuple[Thing, ...]

    def to_json(self) -> dict[str, Any]:
        """The body of EVENT."""
        return {"event": "things", "things": [thing.to_json() for thing in self.things]}

    @classmethod
    def from_json(cls, body: Mapping[str, Any]) -> Things:
        """Read the body of EVENT; no two things may have one id."""
        things = tuple(Thing.from_json(item) for item in _array(body.get("things"), "things", MAX_THINGS))
        if len({thing.id for thing in things}) < len(things):
            raise LinkError("things: two with one id")
        return cls(things)
