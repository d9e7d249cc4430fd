"""Move: the robot goes straight and turns on the spot (component 15)."""

from math import radians
from typing import Annotated, Any, Final

from kachaka_api.generated import kachaka_api_pb2 as pb2
from pydantic import Field

from openrois.adapter import BadParameter, components, parameter
from openrois_robots.kachaka.api.commands import Commands
from openrois_robots.kachaka.components.acting import Acting
from openrois_robots.kachaka.limits import DrivingLimits
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["Move"]

_FARTHEST: Final = 100_000
_MOST_DEGREES: Final = 3600
_SLOWEST: Final = 0.01
_PART: Final = 179
"""Degrees of one turn: which way round the robot goes for half a turn and more is not known."""


class Move(Acting, components.Move):
    """Goes `line` millimetres straight, then turns by its degrees; a curve is refused.

    Args:
        robot: the robot.
        commands: at it.
        limits: the highest speed.
    """

    time: Annotated[int, Field(ge=0)] | None = parameter(None)

    def __init__(self, robot: Kachaka, commands: Commands, limits: DrivingLimits) -> None:
        super().__init__(robot, commands)
        self._limits = limits

    def accept_parameters(self, changes: dict[str, Any]) -> dict[str, Any]:
        """Refuse a curve, and a line that the robot cannot go."""
        if changes.get("curve") is not None:
            raise BadParameter(
                "a Kachaka drives no curves: set line, or operate it by hand (Teleoperation), which drives and turns"
            )
        wanted = {"line": self.line, "time": self.time, **changes}
        if wanted["line"] is not None:
            self._speed(_read(wanted["line"])[0], wanted["time"])
        return changes

    async def start(self) -> None:
        """Go, then turn.

        Raises:
            BadParameter: no line is set.
            ComponentFailed: the battery is low, or the robot does not get there.
        """
        if self.line is None:
            raise BadParameter("line is not set; set it before start")
        self.require_charge()
        millimetres, degrees = _read(self.line)
        speed = self._speed(millimetres, self.time)
        if millimetres:
            forward = pb2.MoveForwardCommand(distance_meter=millimetres / 1000, speed=speed)
            await self.perform(pb2.Command(move_forward_command=forward), f"go {millimetres} mm")
        while degrees:
            part = max(-_PART, min(_PART, degrees))
            turn = pb2.RotateInPlaceCommand(angle_radian=radians(part))
            await self.perform(pb2.Command(rotate_in_place_command=turn), f"turn by {part} degrees")
            degrees -= part

    def _speed(self, millimetres: int, time: int | None) -> float:
        """Return the speed in m/s; raises BadParameter where the robot cannot go so."""
        if not time or not millimetres:
            return self._limits.speed
        speed = abs(millimetres) / time
        if not _SLOWEST <= speed <= self._limits.speed:
            raise BadParameter(
                f"time: {abs(millimetres)} mm in {time} ms are {speed:.2g} m/s;"
                f" the speed must be between {_SLOWEST:g} and {self._limits.speed:g} m/s"
            )
        return speed


def _read(line: tuple[int, ...]) -> tuple[int, int]:
    if len(line) != 2:
        raise BadParameter("line: expected two numbers, millimetres and degrees")
    if abs(line[0]) > _FARTHEST or abs(line[1]) > _MOST_DEGREES:
        raise BadParameter(f"line: expected at most {_FARTHEST} mm and {_MOST_DEGREES} degrees, not {list(line)}")
    return line[0], line[1]
