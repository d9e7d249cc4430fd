"""`openrois robot simulated`: run the simulated robot until a signal stops it."""

from typing import Final

from openrois_robots.adapter.process import RobotCommand, run_hosted
from openrois_robots.simulated.adapter import hosted_robot, simulated_robot
from openrois_robots.simulated.options import TABLES, add_options, read_settings

__all__ = ["COMMAND"]

COMMAND: Final = RobotCommand(
    "simulated",
    "A mobile robot in simulated rooms, behind a gateway.",
    "robot",
    TABLES,
    add_options,
    read_settings,
    run_hosted(simulated_robot, hosted_robot),
)
"""The command of the simulated robot."""
