"""The limits of a Kachaka in its configuration. Pure."""

from dataclasses import dataclass
from math import isfinite
from typing import Final, Literal

__all__ = ["ANGULAR", "LINEAR", "DrivingLimits", "SpeechSettings", "normalised"]

LINEAR: Final = 0.3
"""Metres a second: the fastest that a Kachaka takes, and the velocity that its API calls 1."""
ANGULAR: Final = 1.57
"""Radians a second, likewise."""


@dataclass(frozen=True, slots=True)
class DrivingLimits:
    """The highest speeds of `Move` and of driving by hand. Those of `Navigation` are the robot's own.

    Attributes:
        speed: m/s ahead and back.
        turn: rad/s by hand; the API lets `Move` choose none.

    Raises:
        ValueError: one is out of bounds.
    """

    speed: float = LINEAR
    turn: float = ANGULAR

    def __post_init__(self) -> None:
        for name, most in (("speed", LINEAR), ("turn", ANGULAR)):
            if not 0.05 <= getattr(self, name) <= most:
                raise ValueError(f"driving.{name} must be between 0.05 and {most:g}, not {getattr(self, name):g}")


@dataclass(frozen=True, slots=True)
class SpeechSettings:
    """Speech.

    Attributes:
        while_driving: what becomes of a text while the robot carries out another command: `ask` leaves it to the
            robot, which says it at once or after that command; `refuse` refuses it with a reason.

    Raises:
        ValueError: there is no such choice.
    """

    while_driving: str = "ask"

    def __post_init__(self) -> None:
        if self.while_driving not in _CHOICES:
            raise ValueError(f"speech.while_driving must be ask or refuse, not {self.while_driving!r}")


_CHOICES: Final[tuple[Literal["ask", "refuse"], ...]] = ("ask", "refuse")


def normalised(ahead: float, turn: float, limits: DrivingLimits) -> tuple[float, float]:
    """Return a velocity (m/s, rad/s) within the limits, as the API takes it: from -1 to 1; no number is to stand."""
    if not isfinite(ahead) or not isfinite(turn):
        return 0.0, 0.0
    ahead = max(-limits.speed, min(limits.speed, ahead))
    turn = max(-limits.turn, min(limits.turn, turn))
    return ahead / LINEAR, turn / ANGULAR
