"""Places on a body's floor: how far and on which side something is, and where to stand before a person. Pure."""

from collections.abc import Mapping
from math import atan2, cos, dist, pi, sin
from typing import Any, Final, NamedTuple

__all__ = ["Place", "before_person", "place_of", "places_by_name", "side_of"]

_APART: Final = 0.9
"""Metres from a person at which the body stops."""
_NEAR: Final = 1.3
"""Metres from a person at which the body is there already."""
_AHEAD: Final = pi / 6
"""Radians to either side that are still ahead, or behind."""


class Place(NamedTuple):
    """Metres and radians; `th` counts counter-clockwise from x."""

    x: float
    y: float
    th: float = 0.0

    def distance(self, other: "Place") -> float:
        """Return the metres between two places."""
        return dist(self[:2], other[:2])


def place_of(text: Any) -> Place | None:
    """Return the place that a text such as `x,y,th` tells; None where it tells none."""
    try:
        return Place(*(float(each) for each in str(text).split(",")))
    except (TypeError, ValueError):
        return None


def places_by_name(told: Any) -> dict[str, Place]:
    """Return what has a place, by name; what is told in another way is left out."""
    named = told.items() if isinstance(told, Mapping) else ()
    return {str(name): place for name, text in named if (place := place_of(text)) is not None}


def before_person(person: Place, at: Place | None) -> Place | None:
    """Return where to stand before a person, facing it; None where the body stands there already.

    Args:
        person: where the person is.
        at: where the body is; None where that is not known: then it comes from where the person looks.
    """
    if at is None:
        towards = person.th
    elif person.distance(at) <= _NEAR:
        return None
    else:
        towards = atan2(at.y - person.y, at.x - person.x)
    x, y = person.x + _APART * cos(towards), person.y + _APART * sin(towards)
    return Place(x, y, atan2(person.y - y, person.x - x))


def side_of(thing: Place, at: Place) -> str:
    """Return on which side of a body a thing is, as the body sees it."""
    angle = (atan2(thing.y - at.y, thing.x - at.x) - at.th + pi) % (2 * pi) - pi
    if abs(angle) <= _AHEAD:
        return "before me"
    if abs(angle) >= pi - _AHEAD:
        return "behind me"
    return "to my left" if angle > 0 else "to my right"
