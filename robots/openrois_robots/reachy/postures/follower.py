"""The next target on the way to a goal: limited speeds and accelerations, whatever the goal does. Pure."""

from math import hypot, sqrt
from typing import Final

from openrois_robots.reachy.postures.limits import STEP, MotionLimits
from openrois_robots.reachy.postures.posture import NEUTRAL, Posture

__all__ = ["Follower"]

_RISE: Final = 0.15
"""Seconds from standing to full speed, and back."""
_SHIFT: Final = 0.1
"""Metres a second that the head is shifted at most."""
_NEAR: Final = 1e-9
_STILL: Final = 1e-6
"""Of the full speed; what is slower stands."""


class Follower:
    """Follows a goal from the posture where the robot is.

    All numbers of a posture are one vector, each as a share of its highest speed: from standing they go straight and
    arrive together.

    Args:
        limits: highest speeds.
        posture: where the robot is.

    Attributes:
        posture: the last target.
    """

    def __init__(self, limits: MotionLimits, posture: Posture = NEUTRAL) -> None:
        head, antennas = limits.head, limits.antennas
        self._speeds = (head, head, head, _SHIFT, _SHIFT, _SHIFT, limits.body, antennas, antennas)
        self.posture = posture
        self._velocity = (0.0,) * len(self._speeds)

    @property
    def is_still(self) -> bool:
        """Whether the last target was that before it."""
        return hypot(*self._velocity) < _STILL

    def restart(self, posture: Posture) -> None:
        """Stand at a posture: where the robot is."""
        self.posture = posture
        self._velocity = (0.0,) * len(self._speeds)

    def rest(self) -> Posture:
        """Return where it comes to stand soonest."""
        pace = hypot(*self._velocity)
        way = pace * _RISE / 2
        moved = (
            value + speed * way * share
            for value, speed, share in zip(self.posture.numbers, self._speeds, self._velocity, strict=True)
        )
        return Posture(*moved).within_reach()

    def step(self, goal: Posture, pace: float = 1.0) -> Posture:
        """Return the next target, `STEP` after the last one.

        Args:
            goal: where it goes; what is out of reach is approached as far as may be.
            pace: share of the highest speeds, above 0 and at most 1.
        """
        goal = goal.within_reach()
        way = tuple(
            (end - now) / speed
            for end, now, speed in zip(goal.numbers, self.posture.numbers, self._speeds, strict=True)
        )
        left = hypot(*way)
        allowed = min(pace, _braking(left), left / STEP)
        wanted = tuple(each / left * allowed for each in way) if left > _NEAR else (0.0,) * len(way)
        self._velocity = _changed(self._velocity, wanted)
        if left <= _NEAR and self.is_still:
            self.posture = goal
            return goal
        moved = (
            now + speed * share * STEP
            for now, speed, share in zip(self.posture.numbers, self._speeds, self._velocity, strict=True)
        )
        self.posture = Posture(*moved).within_reach()
        return self.posture

    def is_at(self, goal: Posture) -> bool:
        """Tell whether it stands at a goal."""
        return self.is_still and self.posture == goal.within_reach()


def _braking(left: float) -> float:
    """Return the speed from which it can stand within a way, in steps."""
    step = STEP / _RISE
    return step * (sqrt(0.25 + 2 * left / (step * STEP)) - 0.5)


def _changed(velocity: tuple[float, ...], wanted: tuple[float, ...]) -> tuple[float, ...]:
    """Return the wanted velocity, or the nearest to it that one step allows."""
    change = tuple(new - old for new, old in zip(wanted, velocity, strict=True))
    size, most = hypot(*change), STEP / _RISE
    if size <= most:
        return wanted
    return tuple(old + each / size * most for old, each in zip(velocity, change, strict=True))
