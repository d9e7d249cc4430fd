"""How the base drives: along a path, by hand, or to a stand, within its speeds and accelerations. Pure.

The base is omnidirectional: it can go sideways and backwards, and turns on the spot.
"""

from dataclasses import dataclass
from itertools import pairwise
from math import atan2, cos, hypot, inf, remainder, sin, sqrt, tau
from typing import Final, NamedTuple

from openrois_body.messages import Completed, Drive, Place, Reached, Status, Walk, Waypoint

__all__ = ["BaseSettings", "DriveControl", "Velocity"]

HOLD: Final = 0.45
"""Seconds for which a `Drive` holds; the rest of its half second is for standing still."""
STUCK: Final = 4.0
"""Seconds without progress on a path after which the base is stuck."""
_PROGRESS: Final = 0.05
"""Metres, or quarters of a radian, that count as progress."""
_QUARTER: Final = 0.25
_NEAR: Final = 0.02
"""Metres from a waypoint at which it is reached; where the path goes on, `_PASSING`."""
_PASSING: Final = 0.06
_FACING: Final = 0.03
"""Radians from a direction at which it is reached; where the path goes on, `_TURNING`."""
_TURNING: Final = 0.15
_ASIDE: Final = 0.5
"""Metres before a waypoint with a direction at which the base begins to turn that way, and radians of that turn that
may be left when it goes on."""
_ROOM: Final = 0.06
"""Metres that are kept to what is ahead."""
_EAGERNESS: Final = 4.0
"""Turning speed in rad/s for each radian that is left."""


@dataclass(frozen=True, slots=True)
class BaseSettings:
    """Speeds and accelerations that are never exceeded.

    Attributes:
        speed: m/s.
        turn: rad/s.
        acceleration: m/s^2.
        braking: m/s^2.
        turn_acceleration: rad/s^2.

    Raises:
        ValueError: a value is out of bounds; the text names it.
    """

    speed: float = 0.8
    turn: float = 1.8
    acceleration: float = 1.0
    braking: float = 2.5
    turn_acceleration: float = 8.0

    def __post_init__(self) -> None:
        bounds = {
            "speed": (0.05, 2.0),
            "turn": (0.1, 10.0),
            "acceleration": (0.1, 10.0),
            "braking": (0.5, 20.0),
            "turn_acceleration": (0.5, 100.0),
        }
        for name, (low, high) in bounds.items():
            if not low <= getattr(self, name) <= high:
                raise ValueError(f"base.{name} must be between {low:g} and {high:g}, not {getattr(self, name):g}")


class Velocity(NamedTuple):
    """A velocity in the axes of the map: m/s, and rad/s to the left."""

    x: float = 0.0
    y: float = 0.0
    turn: float = 0.0

    @property
    def speed(self) -> float:
        """How fast it is, in m/s."""
        return hypot(self.x, self.y)


@dataclass(slots=True)
class _Path:
    """A path that is driven: the next waypoint, the speed limit at each, and when it last came nearer to the end."""

    walk: Walk
    limits: list[float]
    since: float
    index: int = 0
    least: float = inf

    @property
    def goal(self) -> Waypoint:
        return self.walk.path[self.index]

    @property
    def is_last(self) -> bool:
        return self.index + 1 == len(self.walk.path)


class DriveControl:
    """The control of the base: from commands and its place to a velocity. Times never go back.

    Args:
        settings: its limits.

    Attributes:
        news: what has happened since they were cleared: waypoints that were reached, and ends of paths.
    """

    def __init__(self, settings: BaseSettings) -> None:
        self.settings = settings
        self.news: list[Reached | Completed] = []
        self._path: _Path | None = None
        self._drive = Drive(0.0, 0.0, 0.0)
        self._until = -inf
        self._velocity = Velocity()

    @property
    def velocity(self) -> Velocity:
        """The velocity that was chosen last."""
        return self._velocity

    @property
    def is_at_rest(self) -> bool:
        """Whether it stands, and will until the next command."""
        return self._path is None and self._until == -inf and self._velocity == Velocity()

    def walk(self, walk: Walk, place: Place, now: float) -> None:
        """Drive along a path from a place; a former one is aborted."""
        self.end_motion("ABORT")
        self._path = _Path(walk, _limits(place, walk, self.settings), now)

    def drive(self, drive: Drive, now: float) -> None:
        """Drive by hand for half a second at most; a path is aborted."""
        self.end_motion("ABORT")
        self._drive, self._until = drive, now + HOLD

    def end_motion(self, status: Status, reason: str = "") -> None:
        """Brake to a stand; a path ends so."""
        self._until = -inf
        if self._path is not None:
            self.news.append(Completed(self._path.walk.id, status, reason))
            self._path = None

    def choose(self, place: Place, now: float, seconds: float, room: float) -> Velocity:
        """Return the velocity for the next step.

        Args:
            place: where the base is.
            now: the time at the beginning of the step.
            seconds: that it takes.
            room: metres that are free in the direction in which it last went; at least as far as it needs to brake.
        """
        if self._path is not None:
            self._pass_waypoints(self._path, place, now)
        if self._path is not None:
            wanted = self._along(self._path, place)
        elif now < self._until:
            wanted = self._by_hand(place, self._until - now)
        else:
            self._until, wanted = -inf, Velocity()
        self._velocity = self._limited(wanted, seconds, room)
        return self._velocity

    def _pass_waypoints(self, path: _Path, place: Place, now: float) -> None:
        """Report the waypoints that are reached, the end of the path, and that there is no progress."""
        while _is_at(path, place, self._velocity):
            self.news.append(Reached(path.walk.id, path.index))
            if path.is_last:
                self.end_motion("OK")
                return
            path.index += 1
            path.least = inf
        left = _left(path, place)
        if left < path.least - _PROGRESS:
            path.least, path.since = left, now
        elif now - path.since > STUCK:
            end = path.walk.path[-1]
            away = hypot(end.x - place.x, end.y - place.y)
            self.end_motion(
                "ERROR", f"stuck {away:.2f} m before the goal: something that the map does not have is in the way"
            )

    def _along(self, path: _Path, place: Place) -> Velocity:
        goal, limits = path.goal, self.settings
        dx, dy = goal.x - place.x, goal.y - place.y
        away = hypot(dx, dy)
        nearly = _NEAR if path.is_last else _PASSING
        if away <= nearly / 2:
            return Velocity(0.0, 0.0, 0.0 if goal.th is None else self._turn_to(goal.th, place))
        if goal.th is not None and away < _ASIDE:
            # It turns before it goes sideways or backwards.
            facing, share = goal.th, 1.0 if abs(remainder(goal.th - place.th, tau)) < _ASIDE else 0.0
        elif away < _PASSING:
            # Turning towards a point that is as near as this would take it around the point.
            facing, share = place.th, 1.0
        else:
            facing = atan2(dy, dx)
            share = max(0.0, cos(remainder(facing - place.th, tau))) ** 3
        limit = sqrt(path.limits[path.index] ** 2 + limits.acceleration * max(0.0, away - nearly / 2)) + 0.02
        speed = share * min(path.walk.speed, limits.speed, limit)
        return Velocity(dx / away * speed, dy / away * speed, self._turn_to(facing, place))

    def _by_hand(self, place: Place, seconds: float) -> Velocity:
        """Return the velocity of a drive that ends in so many seconds: slow enough to stand soon after it."""
        drive, limits = self._drive, self.settings
        asked = hypot(drive.ahead, drive.left)
        share = min(1.0, min(limits.speed, limits.braking * max(seconds, 0.1)) / asked) if asked else 0.0
        ahead, left = drive.ahead * share, drive.left * share
        c, s = cos(place.th), sin(place.th)
        return Velocity(ahead * c - left * s, ahead * s + left * c, drive.turn)

    def _turn_to(self, angle: float, place: Place) -> float:
        return _EAGERNESS * remainder(angle - place.th, tau)

    def _limited(self, wanted: Velocity, seconds: float, room: float) -> Velocity:
        """Return a velocity that is possible from the present one, and not faster than the room ahead allows."""
        limits, now = self.settings, self._velocity
        brakes = wanted.speed < now.speed
        dx, dy = wanted.x - now.x, wanted.y - now.y
        step = (limits.braking if brakes else limits.acceleration) * seconds
        share = min(1.0, step / max(hypot(dx, dy), 1e-9))
        x, y = now.x + dx * share, now.y + dy * share
        most = min(limits.speed, sqrt(2 * limits.braking * max(0.0, room - _ROOM)))
        if hypot(x, y) > most:
            x, y = x * most / hypot(x, y), y * most / hypot(x, y)
        turn = max(-limits.turn, min(limits.turn, wanted.turn))
        most_turn = limits.turn_acceleration * seconds
        turn = now.turn + max(-most_turn, min(most_turn, turn - now.turn))
        return Velocity(x, y, turn)


def _is_at(path: _Path, place: Place, velocity: Velocity) -> bool:
    goal = path.goal
    near, facing = (_NEAR, _FACING) if path.is_last else (_PASSING, _TURNING)
    if hypot(goal.x - place.x, goal.y - place.y) > near:
        return False
    if goal.th is not None and abs(remainder(goal.th - place.th, tau)) > facing:
        return False
    return not path.is_last or velocity.speed < 0.1


def _left(path: _Path, place: Place) -> float:
    """Return what is left up to the next waypoint: metres, and the turn at its end."""
    goal = path.goal
    away = hypot(goal.x - place.x, goal.y - place.y)
    facing = goal.th if goal.th is not None and away < _ASIDE else atan2(goal.y - place.y, goal.x - place.x)
    turn = abs(remainder(facing - place.th, tau)) if goal.th is not None or away > _PASSING else 0.0
    return away + _QUARTER * turn


def _limits(start: Place, walk: Walk, settings: BaseSettings) -> list[float]:
    """Return the speed at each waypoint, in m/s: the less the sharper the corner, and none at the end."""
    points = [(start.x, start.y), *((at.x, at.y) for at in walk.path)]
    steps = [(bx - ax, by - ay) for (ax, ay), (bx, by) in pairwise(points)]
    limits = [0.0] * len(steps)
    top = min(walk.speed, settings.speed)
    for index in range(len(steps) - 2, -1, -1):
        (ax, ay), (bx, by) = steps[index], steps[index + 1]
        before, after = hypot(ax, ay), hypot(bx, by)
        straight = (ax * bx + ay * by) / (before * after) if before and after else 0.0
        # A waypoint with a direction is not passed by.
        corner = 0.0 if walk.path[index].th is not None else top * max(0.0, straight) ** 2
        limits[index] = min(corner, sqrt(limits[index + 1] ** 2 + settings.acceleration * after))
    return limits
