"""Teleoperation of a robot that steers by velocity. A component of OpenRoIS."""

from collections.abc import Mapping
from typing import Any

from openrois_body.components import teleoperation
from openrois_body.motion.legs import Legs
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_body.teleoperation.steering import Velocity
from openrois_streaming.clock import MediaClock

from openrois_robots.ros2.components.bound import Ends

__all__ = ["RobotControls", "Teleoperation"]


class RobotControls:
    """The controls of a robot without eyes.

    Args:
        legs: drive it, and end what it does by itself.
    """

    def __init__(self, legs: Legs) -> None:
        self._legs = legs

    def drive(self, velocity: Velocity) -> None:
        """Go with this velocity for half a second at most.

        Raises:
            ComponentFailed: no node takes the velocity.
        """
        self._legs.drive(velocity.ahead, velocity.left, velocity.turn)

    def halt(self, reason: str) -> None:
        """Stand still now."""
        self._legs.halt(reason)

    def turn_eyes(self, x: float, y: float) -> None:
        """Do nothing: the robot has no eyes that turn."""

    def pass_on(self, message: Mapping[str, Any]) -> None:
        """Do nothing: there is no game engine."""


class Teleoperation(teleoperation.Teleoperation):
    """Lets the application that has bound it drive the robot.

    Args:
        operator_control: knows which application operates.
        controls: of the robot.
        ends: that it needs.
        clock: the media clock.
    """

    def __init__(
        self, operator_control: OperatorControl, controls: RobotControls, ends: Ends, clock: MediaClock
    ) -> None:
        super().__init__(operator_control, controls, lambda: ends.status, clock)
        self._ends = ends

    def problem(self) -> str:
        """Return why the robot cannot be driven."""
        return self._ends.problem
