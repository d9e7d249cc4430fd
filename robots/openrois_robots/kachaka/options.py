"""Settings of a Kachaka's adapter, from its options and its configuration file."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from openrois_robots.adapter.battery import BatteryLimit
from openrois_robots.adapter.options import RobotTable, add_robot_option, read_config, read_table, robot_address
from openrois_robots.kachaka.api.address import PORT, Address, read_address
from openrois_robots.kachaka.limits import DrivingLimits, SpeechSettings

__all__ = ["TABLES", "KachakaSettings", "add_options", "read_settings"]

TABLES: Final = "robot, driving, speech and battery: address and limits"
"""The tables of the configuration file, for the help."""


@dataclass(frozen=True, slots=True)
class KachakaSettings:
    """The settings that only this robot has.

    Attributes:
        address: of the robot.
        driving: highest speeds.
        speech: what becomes of a text while the robot drives.
        battery: below which charge only the charger is a goal.
    """

    address: Address
    driving: DrivingLimits = field(default_factory=DrivingLimits)
    speech: SpeechSettings = field(default_factory=SpeechSettings)
    battery: BatteryLimit = field(default_factory=BatteryLimit)


_READ: Final[Mapping[str, Callable[[str, Any], Any]]] = {
    "robot": partial(read_table, RobotTable),
    "driving": partial(read_table, DrivingLimits),
    "speech": partial(read_table, SpeechSettings),
    "battery": partial(read_table, BatteryLimit),
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that only this robot has."""
    add_robot_option(parser, PORT)


def read_settings(chosen: argparse.Namespace) -> KachakaSettings:
    """Return the settings: the address from its option, else from the configuration file, which has all else.

    Raises:
        ValueError: one is wrong or missing, or the file cannot be read; a sentence for a person.
    """
    tables = read_config(chosen.config, _READ)
    address = read_address(robot_address(chosen, tables["robot"]))
    return KachakaSettings(address, tables["driving"], tables["speech"], tables["battery"])
