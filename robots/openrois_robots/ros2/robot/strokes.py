"""The motions of `Move` for a robot that steers by velocity: straight on, on the spot, on a circle. Pure.

They are closed by the odometry: what counts is how far the robot has come, not for how long it was told to go.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import copysign, cos, hypot, inf, isfinite, remainder, sin, sqrt, tau
from typing import Final

from openrois_body.messages import Place
from openrois_body.teleoperation.steering import STANDING, Velocity

__all__ = ["STUCK", "Limits", "Stroke", "Strokes", "curve_strokes", "line_strokes"]

STUCK: Final = 4.0
"""Seconds without progress after which the robot is stuck."""
_PROGRESS: Final = 0.02
"""Metres, or radians, that count as progress."""
_NEAR: Final = 0.01
_FACING: Final = 0.02
"""Metres and radians before the end at which a stroke has ended."""
_BRAKING: Final = 0.5
_TURN_BRAKING: Final = 1.5
"""m/s^2 and rad/s^2 with which a robot is slowed down before the end."""
_SLOWEST: Final = 0.02
_SLOWEST_TURN: Final = 0.05
_STEADINESS: Final = 1.5
"""rad/s for each radian off the course on a straight line."""


@dataclass(frozen=True, slots=True)
class Limits:
    """The largest velocities: m/s and rad/s."""

    speed: float
    turn: float


@dataclass(frozen=True, slots=True)
class Stroke:
    """A part of a motion.

    Attributes:
        metres: straight on, negative: backwards; or the radius of the circle where `is_circle`.
        radians: to turn, to the left.
        is_circle: whether it goes on a circle.
    """

    metres: float = 0.0
    radians: float = 0.0
    is_circle: bool = False


def line_strokes(values: Sequence[int]) -> list[Stroke]:
    """Return the strokes of a line: millimetres straight on, then degrees of turn to the left."""
    strokes = [Stroke(metres=values[0] / 1000), Stroke(radians=values[1] * tau / 360)]
    return [each for each in strokes if each.metres or each.radians]


def curve_strokes(values: Sequence[int]) -> list[Stroke]:
    """Return the stroke of a curve: on a circle of a radius in millimetres, by degrees to the left."""
    stroke = Stroke(values[0] / 1000, values[1] * tau / 360, is_circle=values[0] > 0)
    return [stroke] if stroke.radians else []


class Strokes:
    """Drives strokes one after another.

    Args:
        strokes: of the motion.
        limits: of its velocity.

    Attributes:
        left: metres, or where it turns radians, to the end of the present stroke.
    """

    def __init__(self, strokes: Sequence[Stroke], limits: Limits) -> None:
        self.left = 0.0
        self._strokes = list(strokes)
        self._limits = limits
        self._start: Place | None = None
        self._turned = 0.0
        self._th = 0.0
        self._least = inf
        self._since = 0.0

    def velocity(self, place: Place, now: float) -> Velocity | None:
        """Return the velocity from a place on; None where the motion has ended.

        Args:
            place: where the robot is, by its odometry.
            now: monotonic seconds.
        """
        while self._strokes:
            if self._start is None:
                self._start, self._th, self._turned = place, place.th, 0.0
                self._least, self._since = inf, now
            self._turned += remainder(place.th - self._th, tau)
            self._th = place.th
            velocity = self._along(self._strokes[0], self._start, place)
            if velocity is not None:
                self._note_progress(now)
                return velocity
            del self._strokes[0]
            self._start = None
        return None

    def rest(self, now: float) -> None:
        """Note that the robot is meant to stand, so that it is not stuck."""
        self._since = now

    def is_stuck(self, now: float) -> bool:
        """Return whether there was no progress for `STUCK` seconds."""
        return bool(self._strokes) and now - self._since > STUCK

    def _note_progress(self, now: float) -> None:
        if self.left < self._least - _PROGRESS:
            self._least, self._since = self.left, now

    def _along(self, stroke: Stroke, start: Place, place: Place) -> Velocity | None:
        """Return the velocity for a stroke; None where it has ended."""
        if stroke.metres and not stroke.radians:
            return self._straight(stroke.metres, start, place)
        left = stroke.radians - self._turned
        self.left = left if stroke.radians > 0 else -left
        if self.left <= _FACING:
            return None
        radius = stroke.metres if stroke.is_circle else 0.0
        most = min(self._limits.turn, self._limits.speed / radius if radius else inf)
        turn = min(most, max(_SLOWEST_TURN, sqrt(2 * _TURN_BRAKING * self.left)))
        return Velocity(turn * radius, 0.0, copysign(turn, stroke.radians))

    def _straight(self, metres: float, start: Place, place: Place) -> Velocity | None:
        gone = (place.x - start.x) * cos(start.th) + (place.y - start.y) * sin(start.th)
        left = metres - gone
        self.left = left if metres > 0 else -left
        if self.left <= _NEAR:
            return None
        speed = min(self._limits.speed, max(_SLOWEST, sqrt(2 * _BRAKING * self.left)))
        off = _STEADINESS * remainder(start.th - place.th, tau)
        turn = max(-self._limits.turn, min(self._limits.turn, off))
        return Velocity(copysign(speed, metres), 0.0, turn)


def clamped(velocity: Velocity, limits: Limits) -> Velocity:
    """Return a velocity within limits, in the same direction; one with numbers that are none is to stand."""
    if not all(map(isfinite, (velocity.ahead, velocity.left, velocity.turn))):
        return STANDING
    speed = hypot(velocity.ahead, velocity.left)
    share = min(1.0, limits.speed / speed) if speed else 1.0
    turn = max(-limits.turn, min(limits.turn, velocity.turn))
    return Velocity(velocity.ahead * share, velocity.left * share, turn)
