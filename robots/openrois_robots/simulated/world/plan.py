"""The plan of the rooms: walls, furniture, persons, the charging mat, and what of it the robot's map has. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, dist, pi, sin
from typing import Final, Literal, TypeAlias

from openrois_body.messages import Floor, Place, Point, Thing

__all__ = ["APARTMENT", "PERSON_RADIUS", "Furniture", "Look", "Mat", "Person", "Plan", "Room", "Wall", "Window"]

Colour: TypeAlias = tuple[float, float, float]
Look: TypeAlias = Literal["box", "table", "sofa", "shelf", "plant", "lamp"]

PERSON_RADIUS: Final = 0.25
"""Metres around the middle of a person that no robot enters."""
_CORNERS: Final = 6
"""Corners of the polygon that stands for a person on the map."""


@dataclass(frozen=True, slots=True)
class Wall:
    """A straight wall along an axis: the rectangle that it covers, in metres, from floor to ceiling."""

    left: float
    bottom: float
    right: float
    top: float


@dataclass(frozen=True, slots=True)
class Furniture:
    """A piece of furniture over a rectangle of the floor.

    Attributes:
        name: that targets may use.
        x: of its middle, in metres.
        y: of its middle.
        width: along x, in metres.
        depth: along y.
        height: above the floor.
        look: how it is drawn.
        colour: of its surface: red, green and blue from 0 to 1.
        is_mapped: whether the robot's map has it.
    """

    name: str
    x: float
    y: float
    width: float
    depth: float
    height: float
    look: Look
    colour: Colour
    is_mapped: bool = True

    @property
    def outline(self) -> tuple[Point, ...]:
        """The corners of its rectangle."""
        return _rectangle(
            self.x - self.width / 2, self.y - self.depth / 2, self.x + self.width / 2, self.y + self.depth / 2
        )


@dataclass(frozen=True, slots=True)
class Person:
    """A person who stands: place, direction, and how clothes and hair are coloured."""

    name: str
    place: Place
    clothes: Colour
    trousers: Colour
    hair: Colour
    skin: Colour

    @property
    def outline(self) -> tuple[Point, ...]:
        """A polygon around the person."""
        angles = [2 * pi * number / _CORNERS for number in range(_CORNERS)]
        reach = PERSON_RADIUS / cos(pi / _CORNERS)
        return tuple((self.place.x + reach * cos(each), self.place.y + reach * sin(each)) for each in angles)


@dataclass(frozen=True, slots=True)
class Mat:
    """The charging mat: a disc on the floor over which the robot charges without contact."""

    name: str
    x: float
    y: float
    radius: float

    def holds(self, x: float, y: float) -> bool:
        """Return whether a robot whose middle is there is charged."""
        return dist((x, y), (self.x, self.y)) <= self.radius


@dataclass(frozen=True, slots=True)
class Window:
    """A window in an outer wall.

    Attributes:
        x: of its middle, on the wall.
        y: of its middle.
        th: where it looks into the room, in radians.
        width: in metres.
    """

    x: float
    y: float
    th: float
    width: float


@dataclass(frozen=True, slots=True)
class Room:
    """A rectangle of the floor, with the colours of its floor and of its walls."""

    left: float
    bottom: float
    right: float
    top: float
    floor: Colour
    walls: Colour
    boards: bool
    """Whether its floor has boards; else tiles."""


@dataclass(frozen=True, slots=True)
class Plan:
    """Everything that stands still, seen from above; metres and radians as `openrois_body.messages.motion` has them.

    Attributes:
        left: edge of the floor, as `bottom`, `right` and `top`.
        walls: within the edges.
        furniture: on the floor.
        persons: who stand there.
        mat: where the robot charges.
        rooms: how the floor is drawn.
        windows: in the outer walls.
        visitor: how the person looks who may walk about; its place is where the person begins.
        start: where the robot begins.
        round: the points between which a walking visitor goes, again and again.
    """

    left: float
    bottom: float
    right: float
    top: float
    walls: tuple[Wall, ...]
    furniture: tuple[Furniture, ...]
    persons: tuple[Person, ...]
    mat: Mat
    rooms: tuple[Room, ...]
    windows: tuple[Window, ...]
    visitor: Person
    start: Place
    round: tuple[Point, ...]

    @property
    def floor(self) -> Floor:
        """The robot's map: where it can go."""
        walls = (_rectangle(each.left, each.bottom, each.right, each.top) for each in self.walls)
        pieces = (piece.outline for piece in self.furniture if piece.is_mapped)
        persons = (person.outline for person in self.persons)
        return Floor(_rectangle(self.left, self.bottom, self.right, self.top), (*walls, *pieces, *persons))

    @property
    def things(self) -> tuple[Thing, ...]:
        """What is on the map, by name: persons, furniture and the charging mat."""
        persons = (
            Thing(each.name, "person", each.place.x, each.place.y, each.place.th, each.name) for each in self.persons
        )
        pieces = (
            Thing(each.name, "object", each.x, each.y, 0.0, each.name) for each in self.furniture if each.is_mapped
        )
        return (*persons, *pieces, Thing(self.mat.name, "object", self.mat.x, self.mat.y, 0.0, self.mat.name))


def _rectangle(left: float, bottom: float, right: float, top: float) -> tuple[Point, ...]:
    return (left, bottom), (right, bottom), (right, top), (left, top)


def _wall_with_doors(x: float, bottom: float, top: float, doors: Sequence[tuple[float, float]]) -> list[Wall]:
    """Return the parts of a wall along y between its doorways, given as pairs of y."""
    ends = [bottom, *(end for door in doors for end in door), top]
    return [Wall(x - _HALF, first, x + _HALF, last) for first, last in zip(ends[::2], ends[1::2], strict=True)]


_HALF: Final = 0.06
"""Half of a wall's thickness, in metres."""
_OAK, _WALNUT, _WHITE = (0.72, 0.55, 0.36), (0.42, 0.28, 0.18), (0.93, 0.92, 0.88)

APARTMENT: Final = Plan(
    left=-5.0,
    bottom=-3.5,
    right=5.0,
    top=3.5,
    walls=(
        *_wall_with_doors(0.0, -3.5, 3.5, [(-1.9, -0.7), (1.1, 2.3)]),
        Wall(_HALF, 0.14, 2.1, 0.26),
        Wall(3.3, 0.14, 5.0, 0.26),
    ),
    furniture=(
        Furniture("sofa", -4.45, 1.6, 0.9, 2.0, 0.8, "sofa", (0.25, 0.42, 0.58)),
        Furniture("coffee table", -2.9, 1.6, 0.7, 1.2, 0.45, "table", _OAK),
        Furniture("bookshelf", -2.6, 3.28, 2.2, 0.4, 1.9, "shelf", _WALNUT),
        Furniture("plant", -0.5, 3.05, 0.5, 0.5, 1.3, "plant", (0.25, 0.5, 0.22)),
        Furniture("lamp", -4.6, 3.1, 0.4, 0.4, 1.7, "lamp", (0.95, 0.85, 0.6)),
        Furniture("counter", 2.6, 3.18, 3.4, 0.6, 0.9, "box", _WHITE),
        Furniture("fridge", 4.66, 3.14, 0.64, 0.68, 1.8, "box", (0.78, 0.8, 0.82)),
        Furniture("kitchen table", 3.5, 1.5, 1.3, 0.8, 0.75, "table", _OAK),
        Furniture("desk", 4.5, -1.4, 0.9, 1.7, 0.75, "table", _WALNUT),
        Furniture("cupboard", 1.3, -3.26, 1.8, 0.44, 1.5, "shelf", _OAK),
        # The map does not have it: a robot that is sent to this corner gets stuck before it.
        Furniture("parcel", 4.6, -3.1, 0.7, 0.7, 0.6, "box", (0.7, 0.52, 0.3), is_mapped=False),
    ),
    persons=(
        Person(
            "reader", Place(-1.1, 1.9, -2.2), (0.72, 0.2, 0.22), (0.2, 0.22, 0.3), (0.2, 0.13, 0.08), (0.9, 0.72, 0.6)
        ),
        Person(
            "cook", Place(1.5, 2.45, -2.6), (0.93, 0.93, 0.95), (0.3, 0.3, 0.34), (0.1, 0.08, 0.07), (0.84, 0.64, 0.5)
        ),
        Person(
            "clerk", Place(2.7, -2.2, 2.6), (0.2, 0.5, 0.42), (0.35, 0.3, 0.25), (0.34, 0.2, 0.1), (0.9, 0.73, 0.61)
        ),
    ),
    mat=Mat("dock", -4.0, -2.5, 0.85),
    rooms=(
        Room(-5.0, -3.5, 0.0, 3.5, (0.74, 0.58, 0.42), (0.86, 0.83, 0.74), boards=True),
        Room(0.0, 0.2, 5.0, 3.5, (0.82, 0.82, 0.8), (0.72, 0.82, 0.8), boards=False),
        Room(0.0, -3.5, 5.0, 0.2, (0.55, 0.6, 0.66), (0.8, 0.76, 0.84), boards=False),
    ),
    windows=(
        Window(-5.0, -0.9, 0.0, 1.5),
        Window(-3.2, -3.5, pi / 2, 1.4),
        Window(-1.0, -3.5, pi / 2, 1.4),
        Window(5.0, 1.6, pi, 1.5),
        Window(5.0, -1.4, pi, 1.6),
        Window(3.2, -3.5, pi / 2, 1.4),
    ),
    visitor=Person(
        "visitor", Place(-2.0, -0.6, 0.0), (0.9, 0.7, 0.2), (0.18, 0.28, 0.4), (0.36, 0.2, 0.1), (0.93, 0.76, 0.64)
    ),
    start=Place(-4.0, -2.5, pi / 4),
    round=((-2.0, -2.4), (-0.8, -1.3), (1.6, -1.3), (-0.8, -1.3), (-2.0, -0.6)),
)
"""A living room on the left with the charging mat, a kitchen above and an office below on the right."""
