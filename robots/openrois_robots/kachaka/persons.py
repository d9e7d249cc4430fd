"""Where the persons are that the robot detects, and which of them was there before. Pure."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import atan2, cos, hypot, inf, pi, sin, tan
from typing import Final

from openrois_body.sensing.changes import Place
from openrois_body.vision.box import Box
from openrois_body.vision.sighting import Person, Refs

__all__ = ["DetectedRefs", "Found", "Lens", "PersonTracks", "is_located"]

_VIEW: Final = pi / 3
"""Angle that a camera is taken to see from left to right, where the robot has not told it."""
_LEAST_SCORE: Final = 0.5
"""Score from which on a detection counts."""
_MOST: Final = 50
"""Persons that are there at once."""
_NEAR: Final = 0.7
"""Metres that a person moves at most from one detection to the next one."""
_MEMORY: Final = 1.0
"""Seconds for which a person counts as there after the last detection: the robot misses some."""


@dataclass(frozen=True, slots=True)
class Lens:
    """The geometry of the camera: its width, and focal length and middle in pixels."""

    width: float
    height: float
    focal: float
    centre: float

    @classmethod
    def usual(cls, width: float, height: float) -> "Lens":
        """Return a lens that sees a usual angle."""
        return cls(width, height, width / 2 / tan(_VIEW / 2), width / 2)


@dataclass(frozen=True, slots=True)
class Found:
    """A person that the robot has detected: the box in pixels, its score, and the distance in metres.

    The distance is 0 where the robot could not measure it.
    """

    left: float
    top: float
    width: float
    height: float
    score: float
    distance: float


@dataclass(frozen=True, slots=True)
class _Track:
    """A person, and when it was found last."""

    person: Person
    found_at: float


class PersonTracks:
    """The persons that are there, by their places: the robot gives its detections no names."""

    def __init__(self) -> None:
        self._tracks: list[_Track] = []
        self._last = 0

    def update(self, found: Sequence[Found], lens: Lens, now: float) -> tuple[Person, ...]:
        """Return the persons that are there with new detections, in the order in which they came.

        Args:
            found: what the robot has detected.
            lens: of its camera.
            now: the time of the detection, in seconds.
        """
        left = [_located(each, lens) for each in [each for each in found if each.score >= _LEAST_SCORE][:_MOST]]
        tracks = []
        for track in self._tracks:
            nearest = min(left, key=lambda place, track=track: _away(place[1], track.person.place), default=None)  # type: ignore[misc]
            if nearest is not None and _away(nearest[1], track.person.place) <= _NEAR:
                left.remove(nearest)
                tracks.append(_Track(replace(track.person, box=nearest[0], place=nearest[1]), now))
            elif now - track.found_at <= _MEMORY:
                tracks.append(track)
        self._tracks = [*tracks, *self._new(left, now)][:_MOST]
        return tuple(track.person for track in self._tracks)

    def clear(self) -> None:
        """Forget all persons; numbers are not used again."""
        self._tracks = []

    def _new(self, located: Iterable[tuple[Box, Place]], now: float) -> Iterable[_Track]:
        for box, place in located:
            self._last += 1
            yield _Track(Person(self._last, box, place, face=False), now)


def is_located(person: Person) -> bool:
    """Tell whether the robot could measure how far away a person is."""
    return (person.place.x, person.place.y) != (0.0, 0.0)


class DetectedRefs(Refs):
    """The refs of persons that the robot has detected: other persons than those of our own vision."""

    def person(self, person: Person) -> str:
        """Return the ref of a person."""
        return self._ref("person", f"detected/{person.number}")


def _located(found: Found, lens: Lens) -> tuple[Box, Place]:
    """Return where a person is: the camera is at the origin and looks along y, x is to the right in the picture."""
    box = Box(found.left / lens.width, found.top / lens.height, found.width / lens.width, found.height / lens.height)
    bearing = atan2(found.left + found.width / 2 - lens.centre, lens.focal)
    distance = found.distance if 0 < found.distance < inf else 0.0
    x, y = distance * sin(bearing), distance * cos(bearing)
    return box, Place(x, y, atan2(-y, -x) if distance else -pi / 2)


def _away(one: Place, other: Place) -> float:
    return hypot(one.x - other.x, one.y - other.y)
