"""Settings of a Reachy Mini's adapter, from its options and its configuration file."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from openrois_body.speech_options import VoiceChoice, add_voice_options, voice_choice

from openrois_robots.adapter.options import RobotTable, add_robot_option, read_config, read_table, robot_address
from openrois_robots.reachy.daemon.address import PORT, Address, read_address
from openrois_robots.reachy.postures.limits import MotionLimits

__all__ = ["TABLES", "ReachySettings", "add_options", "read_settings"]

TABLES: Final = "robot and motion: address and highest speeds"
"""The tables of the configuration file, for the help."""


@dataclass(frozen=True, slots=True)
class ReachySettings:
    """The settings that only this robot has.

    Attributes:
        address: of the robot's daemon.
        motion: highest speeds.
        voice: what speaks.
    """

    address: Address
    motion: MotionLimits = field(default_factory=MotionLimits)
    voice: VoiceChoice = field(default_factory=VoiceChoice)


_READ: Final[Mapping[str, Callable[[str, Any], Any]]] = {
    "robot": partial(read_table, RobotTable),
    "motion": partial(read_table, MotionLimits),
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that only this robot has."""
    add_robot_option(parser, PORT)
    add_voice_options(parser)


def read_settings(chosen: argparse.Namespace) -> ReachySettings:
    """Return the settings: the address from its option, else from the configuration file, which has all else.

    Raises:
        ValueError: one is wrong or missing, or the file cannot be read; a sentence for a person.
    """
    tables = read_config(chosen.config, _READ)
    return ReachySettings(read_address(robot_address(chosen, tables["robot"])), tables["motion"], voice_choice(chosen))
