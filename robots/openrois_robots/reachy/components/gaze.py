"""Gaze: where the head looks. A component of OpenRoIS."""

from openrois_body.components import gaze

from openrois_robots.reachy.motion import Motion
from openrois_robots.reachy.robot import Reachy

__all__ = ["Gaze"]


class Gaze(gaze.Gaze):
    """Turns the head; the body stays.

    Args:
        robot: the robot.
        motion: of the robot.
    """

    def __init__(self, robot: Reachy, motion: Motion) -> None:
        super().__init__(motion, robot.motion_status)
        self._robot = robot

    def problem(self) -> str:
        """Return why the robot does not move."""
        return self._robot.motion_problem()
