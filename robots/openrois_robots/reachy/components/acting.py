"""What the components that move the robot share: its status, and its stop."""

from openrois.adapter import ComponentStatus
from openrois_robots.reachy.motion import Motion
from openrois_robots.reachy.robot import Reachy

__all__ = ["Acting"]


class Acting:
    """Mixin of a component that moves the robot; it stands before the class that says what it does.

    Attributes:
        robot: the robot.
        motion: of the robot.
    """

    name: str
    robot: Reachy
    motion: Motion

    def condition(self) -> ComponentStatus:
        """Return the status of what moves the robot."""
        return self.robot.motion_status()

    def problem(self) -> str:
        """Return why the robot does not move."""
        return self.robot.motion_problem()

    async def stop(self) -> None:
        """Let the robot stand, its gaze included; `start` ends with ABORT. A motion of another component goes on."""
        await self.motion.stop(self.name, f"{self.name} was stopped")
