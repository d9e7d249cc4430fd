"""Steering: velocity and gaze of the figure from held keys, buttons and axes. Pure.

| | keyboard | gamepad (standard mapping) |
|---|---|---|
| ahead, back | W, S, up, down | left stick, cross up and down |
| turn left, right | A, D, left, right | left stick, cross left and right |
| step left, right | Q, E | bumpers (buttons 4 and 5) |
| look | mouse, first finger | right stick |
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

from openrois_streaming.input.messages import Held

__all__ = ["LONG_WAY", "STANDING", "Steering", "Velocity", "pace", "shaped"]

_AHEAD: Final = {"KeyW": 1.0, "ArrowUp": 1.0, "KeyS": -1.0, "ArrowDown": -1.0}
_TURN: Final = {"KeyA": 1.0, "ArrowLeft": 1.0, "KeyD": -1.0, "ArrowRight": -1.0}
_LEFT: Final = {"KeyQ": 1.0, "KeyE": -1.0}
_AHEAD_BUTTONS: Final = {12: 1.0, 13: -1.0}
_TURN_BUTTONS: Final = {14: 1.0, 15: -1.0}
_LEFT_BUTTONS: Final = {4: 1.0, 5: -1.0}


@dataclass(frozen=True, slots=True)
class Velocity:
    """A velocity of the figure: m/s ahead and to its left, rad/s to its left."""

    ahead: float = 0.0
    left: float = 0.0
    turn: float = 0.0


STANDING: Final = Velocity()

LONG_WAY: Final = 0.5
"""Round trip to the operator in seconds above which the figure goes slower."""


def pace(round_trip: float) -> float:
    """Return the share of the full speed, above 0 and at most 1, for a round trip of so many seconds.

    Before the operator can see what was done and react, the figure goes no farther than on a path of `LONG_WAY`.
    """
    return 1.0 if round_trip <= LONG_WAY else LONG_WAY / round_trip


def shaped(deflection: float, dead_zone: float, expo: float) -> float:
    """Return the response, from -1 to 1, to a stick's deflection from -1 to 1.

    Args:
        deflection: from the middle.
        dead_zone: deflections up to this have no effect; from there on the response begins at 0.
        expo: 0 is a straight line, 1 a cubic curve: fine near the middle, and the end stays where it is.
    """
    size = min(1.0, abs(deflection))
    if size <= dead_zone:
        return 0.0
    rest = (size - dead_zone) / (1 - dead_zone)
    asked = (1 - expo) * rest + expo * rest**3
    return asked if deflection > 0 else -asked


@dataclass(frozen=True, slots=True)
class Steering:
    """Parameters of the steering.

    Attributes:
        max_speed: m/s at full deflection; stepping sideways is half as fast.
        max_turn: rad/s at full deflection.
        dead_zone: of each axis of a stick.
        expo: of each axis of a stick.
    """

    max_speed: float = 0.8
    max_turn: float = 1.5
    dead_zone: float = 0.12
    expo: float = 0.5

    def at(self, pace: float) -> "Steering":
        """Return the same parameters at a share of the speed; the gaze does not change."""
        return replace(self, max_speed=self.max_speed * pace, max_turn=self.max_turn * pace)

    def velocity(self, held: Held) -> Velocity:
        """Return the velocity; `STANDING` without input. Contradicting keys cancel each other."""
        ahead = self._asked(held, _AHEAD, _AHEAD_BUTTONS) - self._stick(held, 1)
        turn = self._asked(held, _TURN, _TURN_BUTTONS) - self._stick(held, 0)
        left = self._asked(held, _LEFT, _LEFT_BUTTONS)
        return Velocity(_unit(ahead) * self.max_speed, _unit(left) * self.max_speed / 2, _unit(turn) * self.max_turn)

    def gaze(self, held: Held) -> tuple[float, float] | None:
        """Return the gaze: x from -1 (the viewer's left) to 1, y from -1 (down) to 1; None without input."""
        x, y = self._stick(held, 2), -self._stick(held, 3)
        if x or y:
            return x, y
        at = held.touches[0] if held.touches else held.pointer
        return None if at is None else (2 * at.x - 1, 1 - 2 * at.y)

    def _stick(self, held: Held, axis: int) -> float:
        deflection = 0.0 if held.gamepad is None else held.gamepad.axis(axis)
        return shaped(deflection, self.dead_zone, self.expo)

    @staticmethod
    def _asked(held: Held, keys: Mapping[str, float], buttons: Mapping[int, float]) -> float:
        asked = sum(way for code, way in keys.items() if code in held.keys)
        if held.gamepad is not None:
            asked += sum(way * round(held.gamepad.button(index)) for index, way in buttons.items())
        return asked


def _unit(asked: float) -> float:
    return min(1.0, max(-1.0, asked)) + 0.0
