"""`openrois robot simulated`: run the simulated robot until a signal stops it."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final

from openrois_streaming.clock import SystemClock

from openrois_robots.adapter.options import AdapterSettings
from openrois_robots.adapter.process import RobotCommand, RunningRobot
from openrois_robots.simulated.adapter import hosted_robot, simulated_robot
from openrois_robots.simulated.options import TABLES, add_options, read_settings
from openrois_robots.simulated.simulation import SimulationSettings

__all__ = ["COMMAND"]


@asynccontextmanager
async def _run(settings: AdapterSettings, simulation: SimulationSettings) -> AsyncIterator[RunningRobot]:
    clock = SystemClock()
    async with (
        simulated_robot(settings.engine_id, simulation, clock) as robot,
        hosted_robot(settings.engine_id, robot, clock, settings.network) as running,
    ):
        yield running


COMMAND: Final = RobotCommand(
    "simulated",
    "A mobile robot in simulated rooms, behind a gateway.",
    "robot",
    TABLES,
    add_options,
    read_settings,
    _run,
)
"""The command of the simulated robot."""
