"""The simulated robot: a base on two wheels that obeys a velocity or drives to a goal, and its battery. Pure."""

from dataclasses import dataclass
from math import atan2, copysign, cos, hypot, remainder, sin, sqrt, tau
from typing import Final

__all__ = ["EDGE", "WATCHDOG", "Goal", "Model"]

WATCHDOG: Final = 0.5
"""Seconds after which the base stands where no velocity has come."""
EDGE: Final = 5.0
"""Metres from the middle of its floor to each edge, where it stops."""
_SPEED, _TURN = 0.8, 1.6
"""The fastest that the base is: m/s and rad/s."""
_ACCELERATION, _TURN_ACCELERATION = 2.0, 6.0
"""m/s^2 and rad/s^2."""
_NEAR: Final = 0.05
_FACING: Final = 0.05
_HOUR: Final = 3600.0


@dataclass(slots=True)
class Goal:
    """A goal: a pose, and whether the robot has passed from driving to turning."""

    x: float
    y: float
    th: float
    is_there: bool = False


@dataclass(slots=True)
class Model:
    """The robot.

    Attributes:
        x: metres from the middle of its floor.
        y: metres.
        th: radians to the left of the x axis.
        speed: m/s.
        turn: rad/s to the left.
        percent: charge of the battery.
        limit: m/s that goals are driven with at most.
    """

    x: float = 0.0
    y: float = 0.0
    th: float = 0.0
    speed: float = 0.0
    turn: float = 0.0
    percent: float = 80.0
    limit: float = _SPEED
    _wanted: tuple[float, float] = (0.0, 0.0)
    _told_at: float = -WATCHDOG
    _goal: Goal | None = None

    @property
    def goal(self) -> Goal | None:
        """The goal to which it drives."""
        return self._goal

    def obey(self, speed: float, turn: float, now: float) -> None:
        """Go with a velocity until the watchdog ends it; a goal goes on where the velocity is zero."""
        self._wanted, self._told_at = (speed, turn), now
        if speed or turn:
            self._goal = None

    def pursue(self, goal: Goal | None) -> None:
        """Drive to a goal, or stand."""
        self._goal = goal
        self._wanted = 0.0, 0.0

    def step(self, seconds: float, now: float) -> None:
        """Let time pass."""
        speed, turn = self._choose(now)
        speed = max(-_SPEED, min(_SPEED, speed))
        turn = max(-_TURN, min(_TURN, turn))
        self.speed += _bounded(speed - self.speed, _ACCELERATION * seconds)
        self.turn += _bounded(turn - self.turn, _TURN_ACCELERATION * seconds)
        self.th = remainder(self.th + self.turn * seconds, tau)
        self.x = max(-EDGE, min(EDGE, self.x + self.speed * cos(self.th) * seconds))
        self.y = max(-EDGE, min(EDGE, self.y + self.speed * sin(self.th) * seconds))
        effort = 5.0 if self.speed or self.turn else 1.0
        self.percent = max(0.0, self.percent - effort * seconds / _HOUR)

    def _choose(self, now: float) -> tuple[float, float]:
        goal = self._goal
        if goal is None:
            return self._wanted if now - self._told_at <= WATCHDOG else (0.0, 0.0)
        dx, dy = goal.x - self.x, goal.y - self.y
        away = hypot(dx, dy)
        goal.is_there = goal.is_there or away <= _NEAR
        off = remainder((goal.th if goal.is_there else atan2(dy, dx)) - self.th, tau)
        if goal.is_there:
            if abs(off) <= _FACING and abs(self.speed) < 0.01:
                self._goal = None
                return 0.0, 0.0
            return 0.0, _eased(off, _TURN_ACCELERATION / 2)
        share = max(0.0, cos(off)) ** 3
        return min(self.limit, sqrt(_ACCELERATION * away)) * share, _eased(off, _TURN_ACCELERATION / 2)


def _eased(off: float, braking: float) -> float:
    """Return a turning speed that ends where the direction is reached."""
    return copysign(min(_TURN, sqrt(2 * braking * abs(off)), 4 * abs(off)), off)


def _bounded(change: float, most: float) -> float:
    return max(-most, min(most, change))
