"""The gait: motion of legs, arms and trunk while walking. Pure."""

from collections.abc import Mapping
from math import cos, exp, hypot, pi, sin
from typing import Final

_SHORTEST, _LONGER = 0.55, 0.50
"""Length of a stride, two steps, in metres: at hardly any speed, and per m/s."""
_LEG: Final = 0.75
"""Length of a leg in metres."""
_TURNING: Final = 0.16
"""A turn of 1 rad/s takes as many steps as so many m/s."""
_ASIDE: Final = 0.45
"""Share of a step to the side that looks like one ahead."""
_RISE: Final = 9.0
"""Rate at which steps become larger and smaller, in 1/s."""
_MOST: Final = 0.62
"""Farthest that a leg swings, in radians."""


class Steps:
    """The steps of one figure, which follow its motion so that its feet do not slide."""

    def __init__(self) -> None:
        self._phase = 0.0
        """Of the right leg, in strides: at 0 it is in front, and it is lifted from 0.5 to 1."""
        self._swing = 0.0
        """Swing of the legs to either side, in radians."""
        self._effort = 0.0
        """Intensity of walking, 0 to 1."""

    @property
    def effort(self) -> float:
        """Intensity of walking, 0 (stands) to 1."""
        return self._effort

    def advance(self, ahead: float, left: float, turn: float, seconds: float) -> None:
        """Advance by some seconds with m/s ahead and to the left, and rad/s to the left."""
        speed = hypot(ahead, left) + _TURNING * abs(turn)
        stride = _SHORTEST + _LONGER * speed
        way = -1.0 if ahead < 0.0 else 1.0
        self._phase = (self._phase + way * speed / stride * seconds) % 1.0
        straight = hypot(ahead, _ASIDE * left) / speed if speed else 0.0
        goal = min(_MOST, stride / 4 / _LEG * straight) if speed > _STILL else 0.0
        share = 1 - exp(-_RISE * seconds)
        self._swing += (goal - self._swing) * share
        self._effort += (min(1.0, speed / 0.5) - self._effort) * share
        if speed <= _STILL and self._effort < _STILL:
            self._swing = self._effort = 0.0

    def channels(self) -> Mapping[str, float]:
        """Return the offsets of walking from the body at rest; empty while it stands."""
        if not self._effort:
            return {}
        swing, effort = self._swing, self._effort
        turn = 2 * pi * self._phase
        right, left = _leg(turn, swing, effort), _leg(turn + pi, swing, effort)
        return {
            **{f"right_leg.{name}": value for name, value in right.items()},
            **{f"left_leg.{name}": value for name, value in left.items()},
            **{f"right.{name}": value for name, value in _arm(-cos(turn), swing).items()},
            **{f"left.{name}": value for name, value in _arm(cos(turn), swing).items()},
            # The shoulders turn against the hips, and the weight goes over the leg that stands.
            "twist": -0.14 * swing * cos(turn),
            "head_yaw": 0.10 * swing * cos(turn),
            "side": 0.022 * effort * sin(turn),
            "head_roll": -0.012 * effort * sin(turn),
            "lean": 0.07 * swing,
            "head_pitch": 0.012 * effort * cos(2 * turn),
        }


_STILL: Final = 0.01


def _leg(turn: float, swing: float, effort: float) -> dict[str, float]:
    """Return the angles of one leg, as in `Leg`."""
    lifted = max(0.0, -sin(turn - 0.25))
    pushing = max(0.0, -cos(turn + 0.35)) ** 3 * max(0.0, sin(turn + 0.9))
    return {
        "hip": swing * cos(turn) + 0.30 * effort * lifted * (0.3 + swing),
        "knee": (0.25 + 1.9 * swing) * effort * lifted**1.3 + 0.10 * effort,
        "foot": swing * (-0.9 * pushing + 0.45 * max(0.0, cos(turn)) * max(0.0, -sin(turn - 0.6))),
    }


def _arm(ahead: float, swing: float) -> dict[str, float]:
    """Return the offsets of one arm, `ahead` from -1 (behind) to 1."""
    return {
        "y": -1.9 * swing * ahead - 0.35 * swing,
        "z": swing * (0.30 + 0.55 * max(0.0, ahead)),
        "out": 0.10 * swing,
    }
