"""What serves every body, with the reasons and limits of this robot: operation by hand, and its surroundings."""

from typing import Annotated

from openrois_body.components import surroundings, teleoperation
from openrois_body.teleoperation.operator_control import OperatorControl
from openrois_streaming.clock import MediaClock
from pydantic import Field

from openrois.adapter import parameter
from openrois_robots.kachaka.driver import Driver
from openrois_robots.kachaka.limits import ANGULAR, LINEAR
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["Surroundings", "Teleoperation"]


class Teleoperation(teleoperation.Teleoperation):
    """Lets an application drive the robot: ahead, back, and turns. It cannot step to the side, and has no eyes.

    Args:
        operator_control: knows which application operates.
        driver: of the robot.
        robot: the robot.
        clock: the media clock.
    """

    max_speed: Annotated[float, Field(ge=0.05, le=LINEAR)] = parameter(
        LINEAR, description="m/s at full deflection; the robot's configuration may allow less"
    )
    max_turn: Annotated[float, Field(ge=0.05, le=ANGULAR)] = parameter(
        ANGULAR, description="rad/s at full deflection; the robot's configuration may allow less"
    )

    def __init__(self, operator_control: OperatorControl, driver: Driver, robot: Kachaka, clock: MediaClock) -> None:
        super().__init__(operator_control, driver, robot.status, clock)
        self._robot = robot

    def problem(self) -> str:
        """Return why the robot does not work."""
        return self._robot.problem()


class Surroundings(surroundings.Surroundings):
    """Has the robot's floor, place and locations, as needed to draw a map.

    Args:
        robot: the robot.
        clock: the media clock.
    """

    def __init__(self, robot: Kachaka, clock: MediaClock) -> None:
        super().__init__(robot.world, clock, lambda: robot.link.status)
        self._robot = robot

    def problem(self) -> str:
        """Return why the robot is not linked."""
        return self._robot.link.problem
