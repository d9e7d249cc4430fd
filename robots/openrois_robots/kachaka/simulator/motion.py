"""Legs of a command: what a robot does one after another, each in its own time. Pure."""

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, copysign, cos, hypot, remainder, sin, tau
from typing import Final, Protocol

from openrois_robots.kachaka.simulator.house import House, Pose

__all__ = ["ANGULAR", "LINEAR", "Act", "Blocked", "Body", "Go", "Leg", "Turn", "Wait", "legs_to"]

LINEAR: Final = 0.3
"""Metres a second: the fastest, and what a normalised velocity of 1 is."""
ANGULAR: Final = 1.57
"""Radians a second, likewise."""
_CLOSE: Final = 1e-9


class Blocked(Exception):
    """Something is in the way."""


@dataclass(slots=True)
class Body:
    """What moves.

    Attributes:
        house: where.
        pose: where in it.
    """

    house: House
    pose: Pose

    def move(self, metres: float, radians: float) -> None:
        """Turn, then go ahead.

        Raises:
            Blocked: something is in the way; it has turned.
        """
        th = remainder(self.pose.th + radians, tau)
        self.pose = Pose(self.pose.x, self.pose.y, th)
        x, y = self.pose.x + metres * cos(th), self.pose.y + metres * sin(th)
        # A robot that stands where it should not, because it was set there, can leave.
        if metres and not self.house.is_free(x, y) and self.house.is_free(self.pose.x, self.pose.y):
            raise Blocked
        self.pose = Pose(x, y, th)


class Leg(Protocol):
    """A part of a command."""

    def advance(self, body: Body, seconds: float) -> float | None:
        """Go on, and return the seconds that are left when it has ended; None while it has not.

        Raises:
            Blocked: something is in the way.
        """
        ...


@dataclass(slots=True)
class Turn:
    """Turn by so many radians."""

    left: float

    def advance(self, body: Body, seconds: float) -> float | None:
        """Turn on."""
        used = min(seconds, abs(self.left) / ANGULAR)
        turned = copysign(used * ANGULAR, self.left)
        body.move(0.0, turned)
        self.left -= turned
        return seconds - used if abs(self.left) < _CLOSE else None


@dataclass(slots=True)
class Go:
    """Go so many metres ahead; back where they are negative."""

    left: float
    speed: float = LINEAR

    def advance(self, body: Body, seconds: float) -> float | None:
        """Go on."""
        used = min(seconds, abs(self.left) / self.speed)
        gone = copysign(used * self.speed, self.left)
        body.move(gone, 0.0)
        self.left -= gone
        return seconds - used if abs(self.left) < _CLOSE else None


@dataclass(slots=True)
class Wait:
    """Take so many seconds."""

    left: float

    def advance(self, _body: Body, seconds: float) -> float | None:
        """Wait on."""
        used = min(seconds, self.left)
        self.left -= used
        return seconds - used if self.left < _CLOSE else None


@dataclass(slots=True)
class Act:
    """Do something at once."""

    act: Callable[[], None]

    def advance(self, _body: Body, seconds: float) -> float | None:
        """Do it."""
        self.act()
        return seconds


def legs_to(house: House, start: Pose, end: Pose) -> list[Leg] | None:
    """Return the legs to a pose; None where there is no way."""
    way = house.route(start, end)
    if not way:
        return None
    legs: list[Leg] = []
    at = start
    for point in way:
        away = hypot(point.x - at.x, point.y - at.y)
        bearing = atan2(point.y - at.y, point.x - at.x) if away > _CLOSE else at.th
        legs += [Turn(remainder(bearing - at.th, tau)), Go(away)]
        at = Pose(point.x, point.y, bearing)
    return [*legs, Turn(remainder(end.th - at.th, tau))]
