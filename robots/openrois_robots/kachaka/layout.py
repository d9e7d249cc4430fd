"""The locations and shelves that a robot knows, and targets as applications write them. Pure."""

from dataclasses import dataclass
from math import isfinite, remainder, tau
from typing import Final, TypeVar

from openrois.errors import BadParameter

__all__ = ["HOME", "Layout", "Location", "Shelf", "Target", "is_place"]

HOME: Final = "home"
"""Name of the charger, where no location has it."""

_FAR: Final = 1000.0
"""Largest coordinate, in metres."""
_MOST_NAMED: Final = 10
"""Most names in a sentence that lists them."""

_T = TypeVar("_T", "Location", "Shelf")


@dataclass(frozen=True, slots=True)
class Location:
    """A location that a person has named on the robot's map: metres, radians."""

    id: str
    name: str
    x: float
    y: float
    th: float
    is_charger: bool = False


@dataclass(frozen=True, slots=True)
class Shelf:
    """A shelf that the robot can carry, where it was last, and the location of its home."""

    id: str
    name: str
    x: float
    y: float
    th: float
    home: str


@dataclass(frozen=True, slots=True)
class Target:
    """A place to go to.

    Attributes:
        text: as the application wrote it.
        location: a location that the robot knows; None: coordinates, or the charger.
        is_charger: whether it is the charger.
        x: metres.
        y: metres.
        th: radians; None: the direction of the way.
    """

    text: str
    location: Location | None = None
    is_charger: bool = False
    x: float = 0.0
    y: float = 0.0
    th: float | None = None


@dataclass(frozen=True, slots=True)
class Layout:
    """What a robot knows.

    Attributes:
        locations: with names.
        shelves: that it can carry.
        default_location: id of the location to which it goes without another one.
    """

    locations: tuple[Location, ...]
    shelves: tuple[Shelf, ...]
    default_location: str

    def target(self, text: str) -> Target:
        """Read a target: `x,y` or `x,y,th`, the name or id of a location, or `home`.

        Raises:
            BadParameter: it is none, or the name of several; the text names it.
        """
        location = _found(self.locations, text, "locations")
        if location is not None:
            return Target(text, location, location.is_charger, location.x, location.y, location.th)
        if text == HOME:
            return Target(text, is_charger=True)
        numbers = _numbers(text)
        if numbers is None:
            names = _listed(self.locations)
            raise BadParameter(f"{text!r} is no location of the robot: there is {HOME!r}{names}, or x,y or x,y,th")
        if not is_place(*numbers):
            raise BadParameter(f"{text!r}: expected metres from -{_FAR:g} to {_FAR:g}, and radians")
        th = remainder(numbers[2], tau) if len(numbers) == 3 else None
        return Target(text, x=numbers[0], y=numbers[1], th=th)

    def location(self, text: str) -> Location:
        """Return a location by its name or id.

        Raises:
            BadParameter: there is none, or there are several of this name.
        """
        location = _found(self.locations, text, "locations")
        if location is None:
            raise BadParameter(f"{text!r} is no location of the robot{_among(self.locations)}")
        return location

    def shelf(self, text: str) -> Shelf:
        """Return a shelf by its name or id.

        Raises:
            BadParameter: there is none, or there are several of this name.
        """
        shelf = _found(self.shelves, text, "shelves")
        if shelf is None:
            raise BadParameter(f"{text!r} is no shelf of the robot{_among(self.shelves)}")
        return shelf

    def shelf_name(self, shelf_id: str) -> str:
        """Return the name of a shelf; its id where it is not known."""
        return next((each.name for each in self.shelves if each.id == shelf_id), shelf_id)


def is_place(x: float, y: float, th: float = 0.0) -> bool:
    """Return whether numbers are a place on a map: metres that are not too many, and a direction."""
    return isfinite(th) and abs(x) <= _FAR and abs(y) <= _FAR


def _found(things: tuple[_T, ...], text: str, kind: str) -> _T | None:
    """Return the thing with an id, else that of a name; raises BadParameter where several have it."""
    by_id = next((each for each in things if each.id == text), None)
    named = [each for each in things if each.name == text] if text and by_id is None else []
    if len(named) > 1:
        ids = " or ".join(repr(each.id) for each in named[:_MOST_NAMED])
        raise BadParameter(f"{text!r} is the name of {len(named)} {kind}: use an id, {ids}")
    return by_id or next(iter(named), None)


def _numbers(text: str) -> list[float] | None:
    """Return two or three numbers; None where they are none."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        return None
    return numbers if len(numbers) in (2, 3) else None


def _among(things: tuple[Location, ...] | tuple[Shelf, ...]) -> str:
    listed = _listed(things)
    return f": there is {listed.removeprefix(', ')}" if listed else ": it knows none"


def _listed(things: tuple[Location, ...] | tuple[Shelf, ...]) -> str:
    """Return names, each after a comma; the id of a thing without one."""
    more = ", ..." if len(things) > _MOST_NAMED else ""
    return "".join(f", {(each.name or each.id)!r}" for each in things[:_MOST_NAMED]) + more
