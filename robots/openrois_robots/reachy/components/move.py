"""Move: the body turns on its foot (component 15)."""

from math import degrees, radians
from typing import Annotated, Any, Final

from pydantic import Field

from openrois.adapter import BadParameter, ComponentFailed, components, parameter
from openrois_robots.reachy.components.acting import Acting
from openrois_robots.reachy.motion import Motion
from openrois_robots.reachy.postures.gestures import Frame
from openrois_robots.reachy.postures.limits import MotionLimits
from openrois_robots.reachy.postures.posture import NEUTRAL, RANGES
from openrois_robots.reachy.robot import Reachy

__all__ = ["Move"]

_FARTHEST: Final = RANGES[6][1]
_SLOWEST: Final = 0.02
"""Radians a second."""


class Move(Acting, components.Move):
    """Turns the body by the degrees of `line`, whose millimetres have to be 0: the robot has no wheels.

    Args:
        robot: the robot.
        motion: of the robot.
        limits: the highest speed.
    """

    time: Annotated[int, Field(ge=0)] | None = parameter(None)

    def __init__(self, robot: Reachy, motion: Motion, limits: MotionLimits) -> None:
        super().__init__()
        self.robot = robot
        self.motion = motion
        self._limits = limits

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse a curve, a distance, and a turn that the robot cannot make."""
        if changes.get("curve") is not None:
            raise BadParameter("a Reachy Mini stands on its foot: set line to [0, degrees], which turns its body")
        wanted = {"line": self.line, "time": self.time, **changes}
        if wanted["line"] is not None:
            self._pace(_read(wanted["line"]), wanted["time"])
        return changes

    async def start(self) -> None:
        """Turn, with the head ahead.

        Raises:
            BadParameter: no line is set.
            ComponentFailed: the body does not turn that far, or did not get there.
        """
        if self.line is None:
            raise BadParameter("line is not set; set it before start")
        turn = _read(self.line)
        end = self.motion.posture.body + turn
        if abs(end) > _FARTHEST:
            raise ComponentFailed(
                f"the body turns to {degrees(_FARTHEST):.0f} degrees to either side; this would be {degrees(end):.0f}"
            )
        frame = Frame(NEUTRAL, pace=self._pace(turn, self.time))
        await self.motion.perform(self.name, f"turn by {self.line[1]} degrees", (frame,), turn)

    def _pace(self, turn: float, time: int | None) -> float:
        """Return the share of the highest speed; raises BadParameter where the robot cannot turn so."""
        if not time or not turn:
            return 1.0
        speed = abs(turn) / time * 1000
        if not _SLOWEST <= speed <= self._limits.body:
            raise BadParameter(
                f"time: {degrees(abs(turn)):.0f} degrees in {time} ms are {speed:.2g} rad/s;"
                f" the speed must be between {_SLOWEST:g} and {self._limits.body:g} rad/s"
            )
        return speed / self._limits.body


def _read(line: tuple[int, ...]) -> float:
    if len(line) != 2:
        raise BadParameter("line: expected two numbers, millimetres and degrees")
    if line[0]:
        raise BadParameter(f"line: a Reachy Mini stands on its foot and goes nowhere: set 0 mm, not {line[0]}")
    most = round(2 * degrees(_FARTHEST))
    if abs(line[1]) > most:
        raise BadParameter(f"line: expected at most {most} degrees, not {line[1]}")
    return radians(line[1])
