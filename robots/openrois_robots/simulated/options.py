"""Settings of a simulated robot, from its options and its configuration file."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Final

from openrois_body.speech_options import add_voice_options, voice_choice

from openrois_robots.adapter.options import read_config, read_table
from openrois_robots.simulated.battery import BatterySettings
from openrois_robots.simulated.driving import BaseSettings
from openrois_robots.simulated.simulation import SimulationSettings

__all__ = ["TABLES", "add_options", "read_settings"]

TABLES: Final = "base and battery: speeds and limits"
"""The tables of the configuration file, for the help."""

_READ: Final[Mapping[str, Callable[[str, Any], Any]]] = {
    "base": partial(read_table, BaseSettings),
    "battery": partial(read_table, BatterySettings),
}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that only this robot has."""
    base, battery = BaseSettings(), BatterySettings()
    parser.add_argument("--max-speed", type=float, metavar="M/S", help=f"that the robot goes ({base.speed:g})")
    parser.add_argument("--max-turn", type=float, metavar="RAD/S", help=f"that it turns ({base.turn:g})")
    parser.add_argument(
        "--battery", type=float, metavar="PERCENT", help=f"charge at the beginning ({100 * battery.charge:.0f})"
    )
    parser.add_argument(
        "--battery-low",
        type=float,
        metavar="PERCENT",
        help=f"charge below which only the dock is a goal ({100 * battery.low:.0f})",
    )
    parser.add_argument("--visitor", action="store_true", help="let a person walk about in the robot's rooms")
    add_voice_options(parser)


def read_settings(chosen: argparse.Namespace) -> SimulationSettings:
    """Return the settings: each from its option, else from the configuration file, else its default.

    Raises:
        ValueError: one is wrong, or the file cannot be read; a sentence for a person.
    """
    tables = read_config(chosen.config, _READ)
    base = _replaced(tables["base"], speed=chosen.max_speed, turn=chosen.max_turn)
    battery = _replaced(tables["battery"], charge=_share(chosen.battery), low=_share(chosen.battery_low))
    return SimulationSettings(base, battery, chosen.visitor, voice_choice(chosen))


def _share(percent: float | None) -> float | None:
    return None if percent is None else percent / 100


def _replaced(settings: Any, **options: float | None) -> Any:
    return replace(settings, **{name: value for name, value in options.items() if value is not None})
