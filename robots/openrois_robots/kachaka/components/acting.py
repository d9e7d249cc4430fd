"""What the acting components share: the robot's status, its commands, and the battery's limit."""

from kachaka_api.generated import kachaka_api_pb2 as pb2

from openrois.adapter import ComponentFailed, ComponentStatus
from openrois_robots.kachaka.api.commands import Commands
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["Acting"]


class Acting:
    """Mixin of a component that lets the robot carry out commands; it stands before the standard's base class.

    Args:
        robot: the robot.
        commands: at it.
    """

    name: str

    def __init__(self, robot: Kachaka, commands: Commands) -> None:
        super().__init__()
        self.robot = robot
        self.commands = commands

    def condition(self) -> ComponentStatus:
        """Return the status of the robot."""
        return self.robot.status()

    def problem(self) -> str:
        """Return why the robot does not work."""
        return self.robot.problem()

    async def stop(self) -> None:
        """Cancel what the robot does for this component; `start` ends with ABORT. Commands of others go on."""
        await self.commands.cancel(self.name, f"{self.name} was stopped")

    async def perform(self, command: pb2.Command, doing: str) -> None:
        """Let the robot move, to its end; raises as `Commands.perform`."""
        await self.commands.perform(command, self.name, doing)

    def require_charge(self) -> None:
        """Do nothing where the battery lets the robot go elsewhere than to its charger.

        Raises:
            ComponentFailed: it does not.
        """
        if refusal := self.robot.battery.refusal:
            raise ComponentFailed(refusal)
