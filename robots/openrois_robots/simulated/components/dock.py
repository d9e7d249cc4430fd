"""Dock: the charging mat of a simulated robot. A component of OpenRoIS; the standard has none."""

from openrois.adapter import Component, command, event
from openrois_robots.simulated.battery import Battery
from openrois_robots.simulated.simulation import Simulation

__all__ = ["Dock"]


class Dock(Component, authority="OpenRoIS", function="actuation", part="legs"):
    """Tells how the battery gets on, and has the robot pushed to its charging mat where it cannot drive any more.

    Args:
        simulation: of the robot.
    """

    def __init__(self, simulation: Simulation) -> None:
        super().__init__()
        self._simulation = simulation
        simulation.battery_changed.add(self._on_battery_changed)

    @command
    async def push(self) -> None:
        """Let a person push the robot onto its charging mat, as happens to a real one whose battery is empty."""
        self._simulation.push_to_dock()

    @event
    def battery_changed(self, percent: int, is_charging: bool) -> None:
        """The battery has another charge, or is charged now, or no longer.

        Args:
            percent: its charge
            is_charging: whether it is charged now
        """

    def _on_battery_changed(self, battery: Battery) -> None:
        self.battery_changed(battery.percent, battery.is_charging)
