"""Settings of a Kachaka's adapter, from its options and its configuration file."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from openrois_robots.adapter.battery import BatteryLimit
from openrois_robots.adapter.options import read_config, read_table
from openrois_robots.kachaka.api.address import PORT, Address, read_address
from openrois_robots.kachaka.limits import DrivingLimits, SpeechSettings

__all__ = ["TABLES", "KachakaSettings", "RobotTable", "add_options", "read_settings"]

TABLES: Final = "robot, driving, speech and battery: address and limits"
"""The tables of the configuration file, for the help."""


@dataclass(frozen=True, slots=True)
class RobotTable:
    """The robot.

    Attributes:
        address: `HOST` or `HOST:PORT`; empty: `--robot` says it.
    """

    address: str = ""


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
    parser.add_argument(
        "--robot", metavar="HOST[:PORT]", help=f"where it is (port {PORT} unless given; robot.address of --config)"
    )


def read_settings(chosen: argparse.Namespace) -> KachakaSettings:
    """Return the settings: the address from its option, else from the configuration file, which has all else.

    Raises:
        ValueError: one is wrong or missing, or the file cannot be read; a sentence for a person.
    """
    tables = read_config(chosen.config, _READ)
    address = chosen.robot or tables["robot"].address
    if not address:
        raise ValueError("--robot is missing: say where the robot is, as in --robot 192.168.1.20")
    return KachakaSettings(read_address(address), tables["driving"], tables["speech"], tables["battery"])
