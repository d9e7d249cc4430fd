"""SystemInformation of a robot with a battery (component 1 of the standard, and a query of our own)."""

from collections.abc import Callable

from openrois_body.components import system_information
from openrois_body.messages import Place

from openrois.adapter import ComponentStatus, Payload, query
from openrois.catalog.system_information import EngineStatusResult
from openrois_robots.simulated.battery import Battery

__all__ = ["SystemInformation"]


class BatteryResult(Payload):
    """The battery: its charge in per cent, whether it is charged now, and whether other goals than the dock count."""

    percent: int
    is_charging: bool
    is_low: bool


class SystemInformation(system_information.SystemInformation, function="sensing"):
    """Reports the robot's place, its status and its battery.

    The status is WARNING while the battery is low: all components work, and refuse goals other than the dock.

    Args:
        body_ref: the id by which the robot is known.
        engine_status: returns the status of what moves.
        place: returns where the robot is.
        battery: the robot's battery.
    """

    def __init__(
        self,
        body_ref: str,
        engine_status: Callable[[], ComponentStatus],
        place: Callable[[], Place | None],
        battery: Battery,
    ) -> None:
        super().__init__(body_ref, engine_status, place)
        self._battery = battery

    async def engine_status(self) -> EngineStatusResult:
        """Return whether the robot works, and since when the adapter has been operable."""
        told = await super().engine_status()
        is_warning = self._battery.is_low and told.status is ComponentStatus.READY
        return told.model_copy(update={"status": ComponentStatus.WARNING}) if is_warning else told

    @query
    async def battery(self) -> BatteryResult:
        """Return the state of the battery."""
        battery = self._battery
        return BatteryResult(percent=battery.percent, is_charging=battery.is_charging, is_low=battery.is_low)
