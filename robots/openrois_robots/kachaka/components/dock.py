"""Dock: the robot drives to its charger, and tells how its battery gets on. A component of OpenRoIS."""

from kachaka_api.generated import kachaka_api_pb2 as pb2

from openrois.adapter import Component, command, event
from openrois_robots.adapter.battery import Battery
from openrois_robots.kachaka.api.commands import Commands
from openrois_robots.kachaka.components.acting import Acting
from openrois_robots.kachaka.robot import Kachaka

__all__ = ["Dock"]


class Dock(Acting, Component, authority="OpenRoIS", function="actuation", part="legs"):
    """Sends the robot to its charger, whatever the battery has left.

    Args:
        robot: the robot.
        commands: at it.
    """

    dead_man = 0.5

    def __init__(self, robot: Kachaka, commands: Commands) -> None:
        super().__init__(robot, commands)
        robot.battery_changed.add(self._on_battery_changed)

    @command
    async def start(self) -> None:
        """Drive to the charger.

        Raises:
            ComponentFailed: the robot does not get there.
        """
        await self.perform(pb2.Command(return_home_command=pb2.ReturnHomeCommand()), "go to its charger")

    @command
    async def stop(self) -> None:
        """Stand; `start` ends with ABORT."""
        await super().stop()

    @event
    def battery_changed(self, percent: int, is_charging: bool) -> None:
        """The battery has another charge, or is charged now, or no longer.

        Args:
            percent: its charge
            is_charging: whether it is charged now
        """

    def _on_battery_changed(self, battery: Battery) -> None:
        if battery.percent is not None:
            self.battery_changed(battery.percent, battery.is_charging)
