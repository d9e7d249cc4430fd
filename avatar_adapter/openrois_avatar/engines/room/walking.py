"""Locomotion of a figure: along paths, driven by hand, and standing, with natural turns and changes of speed."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, ceil, cos, hypot, remainder, sin, sqrt, tau
from typing import Final, Literal

from openrois_body.messages.motion import Point

from openrois_avatar.engines.room.plan import Plan
from openrois_avatar.link.messages import Completed, Drive, Place, Reached, Walk, Waypoint

TICK: Final = 0.01
"""Longest step of the integration in seconds, however seldom `advance` is called."""
_LONGEST: Final = 1.0
"""Most seconds that are made up for: after a longer gap a figure is about where it was."""
RADIUS: Final = 0.25
"""Metres from the middle of a driven body to an obstacle at which it stops."""
_NARROW: Final = 0.12
"""The same along a path: its planner knows how close it may pass."""
APART: Final = 0.55
"""Metres from middle to middle at which a figure lets another one go first."""
HOLD: Final = 0.45
"""Seconds for which a `Drive` holds: it acts a picture later, and the sum must not exceed 0.5 s."""
FASTEST: Final = 2.5
QUICKEST: Final = 3.0
"""Highest speed in m/s, and of turns in rad/s."""
_GAINING, _BRAKING = 1.6, 6.0
"""Acceleration in m/s^2: along a path, and at most where it is driven."""
_TURN_GAINING: Final = 16.0
"""Acceleration of turns, in rad/s^2."""
_EAGERNESS: Final = 7.0
"""Turning speed in rad/s per remaining radian."""
_FACING: Final = 0.01
"""Precision of a direction, in radians."""
_PASSING: Final = 0.15
"""The same at a point where the path goes on."""
_ASIDE: Final = 0.5
"""Metres before a waypoint with a direction at which it begins to turn that way, and goes on with smaller steps."""
_SMALL: Final = 0.5
"""Speed of small steps, in m/s."""
_THERE: Final = 1e-6


def turned(angle: float) -> float:
    """Return an angle between -pi and pi."""
    return remainder(angle, tau)


@dataclass(frozen=True, slots=True)
class Pace:
    """The motion of a figure: m/s ahead and to its left, and rad/s to its left."""

    ahead: float = 0.0
    left: float = 0.0
    turn: float = 0.0


STANDING: Final = Pace()


@dataclass(slots=True)
class _Way:
    """A running walk: the index of the next waypoint, and the speed limit at each."""

    walk: Walk
    limits: Sequence[float]
    next: int = 0

    @property
    def goal(self) -> Waypoint:
        return self.walk.path[self.next]


class Walker:
    """One figure on a plan. Times never go back from call to call."""

    def __init__(self, plan: Plan, place: Place, time: float) -> None:
        self._plan = plan
        self._x, self._y, self._th = place.x, place.y, place.th
        self._vx = self._vy = self._turn = 0.0
        self._time, self._tick = time, TICK
        self._way: _Way | None = None
        self._drive = Drive(0.0, 0.0, 0.0)
        self._until = float("-inf")
        self._bearing: float | None = None
        """The direction of a turn on the spot."""
        self._news: list[Reached | Completed] = []

    @property
    def place(self) -> Place:
        """The present place."""
        return Place(self._x, self._y, self._th)

    @property
    def pace(self) -> Pace:
        """The present pace."""
        ahead, left = _rotated(self._vx, self._vy, -self._th)
        return Pace(ahead, left, self._turn)

    @property
    def is_walking(self) -> bool:
        """Whether it follows a path."""
        return self._way is not None

    @property
    def is_driven(self) -> bool:
        """Whether the last `Drive` still holds."""
        return self._time < self._until

    def news(self) -> list[Reached | Completed]:
        """Return the waypoints reached and walks completed since the last call."""
        news, self._news = self._news, []
        return news

    def walk(self, walk: Walk) -> None:
        """Follow a path from the present place; a running walk is aborted."""
        self._give_up()
        self._until, self._bearing = float("-inf"), None
        self._way = _Way(walk, limits((self._x, self._y), walk))

    def drive(self, time: float, drive: Drive) -> None:
        """Go by hand for `HOLD` seconds at most; a running walk is aborted."""
        self._give_up()
        self._drive, self._until, self._bearing = drive, time + HOLD, None

    def turn(self, bearing: float) -> None:
        """Turn on the spot to a direction, in radians, unless a command comes before."""
        self._bearing = bearing

    def stay(self) -> None:
        """Stop turning on the spot; a walk and a drive go on."""
        self._bearing = None

    def halt(self) -> None:
        """Stand still at once."""
        self._give_up()
        self._until, self._bearing = float("-inf"), None
        self._stand()

    def advance(self, time: float, others: Iterable[Point] = ()) -> None:
        """Advance to a time; `others` are the places of other figures, which are avoided."""
        seconds = min(time - self._time, _LONGEST)
        ticks = ceil(seconds / TICK - 1e-6)
        self._tick = seconds / max(1, ticks)
        crowd = tuple(others)
        for number in range(ticks):
            self._go_on(time - (ticks - number) * self._tick, crowd)
        self._time = time

    def _go_on(self, time: float, others: Sequence[Point]) -> None:
        if self._way is not None:
            self._follow(self._way, others)
        elif time < self._until:
            self._obey(self._until - time, others)
        elif self._bearing is not None:
            self._turn_to(self._bearing)
        else:
            self._stand()

    def _turn_to(self, bearing: float) -> None:
        """Advance a turn on the spot by one tick."""
        self._vx = self._vy = 0.0
        self._face(bearing)
        if abs(turned(bearing - self._th)) <= _FACING:
            self._th, self._bearing = turned(bearing), None
            self._stand()

    def _stand(self) -> None:
        self._vx = self._vy = self._turn = 0.0

    def _give_up(self) -> None:
        if self._way is not None:
            self._complete_walk(self._way, "ABORT")

    def _complete_walk(self, way: _Way, status: Literal["OK", "ABORT", "ERROR"]) -> None:
        self._news.append(Completed(way.walk.id, status))
        self._way = None

    def _follow(self, way: _Way, others: Sequence[Point]) -> None:
        """Advance along a path by one tick."""
        goal = way.goal
        dx, dy = goal.x - self._x, goal.y - self._y
        distance = hypot(dx, dy)
        if distance > _THERE:
            along = (dx / distance, dy / distance)
            if _is_in_the_way(self._x, self._y, along, others):
                self._stand()
                return
            speed = self._speed(way, along, distance)
            self._vx, self._vy = along[0] * speed, along[1] * speed
            self._go(way, speed * self._tick)
        else:
            self._vx = self._vy = 0.0
            self._face(self._th if goal.th is None else goal.th)
            self._pass(way)

    def _speed(self, way: _Way, along: Point, distance: float) -> float:
        """Turn as the way to the next waypoint requires, and return the speed in m/s."""
        goal, direction = way.goal, atan2(along[1], along[0])
        limit = sqrt(way.limits[way.next] ** 2 + 2 * _GAINING * distance)
        if goal.th is not None and distance < _ASIDE:
            self._face(goal.th)
            # A figure that does not face there yet turns before it goes on.
            passing = way.limits[way.next] if abs(turned(goal.th - self._th)) <= _PASSING else 0.0
            limit = min(sqrt(passing**2 + 2 * _GAINING * distance), max(_SMALL, way.limits[way.next]))
        else:
            self._face(direction)
            limit *= max(0.0, cos(turned(direction - self._th))) ** 2
        had = max(0.0, self._vx * along[0] + self._vy * along[1])
        return min(had + _GAINING * self._tick, way.walk.speed, FASTEST, limit)

    def _go(self, way: _Way, length: float) -> None:
        """Go so many metres along a path, or to the next stop."""
        while length > _THERE:
            goal = way.goal
            dx, dy = goal.x - self._x, goal.y - self._y
            distance = hypot(dx, dy)
            share = min(1.0, length / distance) if distance else 1.0
            x, y = (goal.x, goal.y) if share == 1.0 else (self._x + dx * share, self._y + dy * share)
            if not self._plan.fits(x, y, _NARROW):
                self._stand()
                self._complete_walk(way, "ERROR")
                return
            self._x, self._y = x, y
            length -= distance
            self._pass(way)
            if self._way is not way or way.goal is goal:
                return

    def _pass(self, way: _Way) -> None:
        """Report the waypoints that are reached."""
        while self._way is way and self._is_at(way):
            self._news.append(Reached(way.walk.id, way.next))
            if way.next + 1 == len(way.walk.path):
                self._th = self._th if way.goal.th is None else turned(way.goal.th)
                self._stand()
                self._complete_walk(way, "OK")
            else:
                way.next += 1

    def _is_at(self, way: _Way) -> bool:
        goal = way.goal
        if hypot(goal.x - self._x, goal.y - self._y) > _THERE:
            return False
        nearly = _FACING if way.next + 1 == len(way.walk.path) else _PASSING
        return goal.th is None or abs(turned(goal.th - self._th)) <= nearly

    def _face(self, angle: float) -> None:
        """Turn towards a direction, the shorter way round."""
        wanted = turned(angle - self._th)
        speed = min(max(_EAGERNESS * wanted, -QUICKEST), QUICKEST)
        self._turn += min(max(speed - self._turn, -_TURN_GAINING * self._tick), _TURN_GAINING * self._tick)
        self._th = turned(self._th + self._turn * self._tick)

    def _obey(self, seconds: float, others: Sequence[Point]) -> None:
        """Advance a drive by one tick, with so many seconds left until it must stand."""
        drive = self._drive
        asked = hypot(drive.ahead, drive.left)
        allowed = min(FASTEST, _BRAKING * seconds)
        share = min(1.0, allowed / asked) if asked else 1.0
        goal = _rotated(drive.ahead * share, drive.left * share, self._th)
        vx, vy = _changed((self._vx, self._vy), goal, _BRAKING * self._tick)
        most = min(QUICKEST, _TURN_GAINING * seconds)
        turn = min(max(drive.turn, -most), most)
        self._turn += min(max(turn - self._turn, -_TURN_GAINING * self._tick), _TURN_GAINING * self._tick)
        self._th = turned(self._th + self._turn * self._tick)
        # An obstacle takes only the part of the step that goes into it: the figure slides along a wall.
        self._vx, self._vy = 0.0, 0.0
        for px, py in ((vx, vy), (vx, 0.0), (0.0, vy)):
            if self._is_free((px, py), others):
                self._vx, self._vy = px, py
                break
        self._x, self._y = self._x + self._vx * self._tick, self._y + self._vy * self._tick

    def _is_free(self, velocity: Point, others: Sequence[Point]) -> bool:
        speed = hypot(*velocity)
        if not speed:
            return True
        along = (velocity[0] / speed, velocity[1] / speed)
        if _is_in_the_way(self._x, self._y, along, others):
            return False
        return self._plan.fits(self._x + velocity[0] * self._tick, self._y + velocity[1] * self._tick, RADIUS)


def limits(start: Point, walk: Walk) -> list[float]:
    """Return the speed limit at each waypoint of a walk, in m/s: low at corners, 0 at the last one."""
    points = [start, *((goal.x, goal.y) for goal in walk.path)]
    steps = [(bx - ax, by - ay) for (ax, ay), (bx, by) in pairwise(points)]
    passing = [0.0] * len(steps)
    for index in range(len(steps) - 2, -1, -1):
        (ax, ay), (bx, by) = steps[index], steps[index + 1]
        before, after = hypot(ax, ay), hypot(bx, by)
        straight = (ax * bx + ay * by) / (before * after) if before and after else 1.0
        th = walk.path[index].th
        aside = th is not None and abs(turned(th - atan2(ay, ax))) > _PASSING
        braking = sqrt(passing[index + 1] ** 2 + 2 * _GAINING * after)
        passing[index] = min(_SMALL if aside else walk.speed, walk.speed * max(0.0, straight) ** 2, braking)
    return passing


def _rotated(x: float, y: float, angle: float) -> Point:
    return x * cos(angle) - y * sin(angle), x * sin(angle) + y * cos(angle)


def _changed(velocity: Point, goal: Point, most: float) -> Point:
    """Return the velocity, changed towards another one by `most` at most."""
    dx, dy = goal[0] - velocity[0], goal[1] - velocity[1]
    share = min(1.0, most / max(hypot(dx, dy), 1e-9))
    return velocity[0] + dx * share, velocity[1] + dy * share


def _is_in_the_way(x: float, y: float, along: Point, others: Sequence[Point]) -> bool:
    """Return whether one of the others is close and ahead."""
    return any(hypot(ox - x, oy - y) < APART and (ox - x) * along[0] + (oy - y) * along[1] > 0.0 for ox, oy in others)
