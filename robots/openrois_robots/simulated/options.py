"""Settings of a simulated robot, from its options and its configuration file."""

import argparse
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Final

from openrois_media.network_options import add_network_options, network_settings
from openrois_streaming.network.settings import NetworkSettings

from openrois.transport.address import adapter_url
from openrois.transport.credential_options import add_credential_options, credentials
from openrois.transport.credentials import NO_CREDENTIALS, Credentials
from openrois_robots.simulated.battery import BatterySettings
from openrois_robots.simulated.driving import BaseSettings
from openrois_robots.simulated.simulation import SimulationSettings

__all__ = ["RobotSettings", "add_options", "read_settings"]

_LARGEST: Final = 1 << 20
"""Bytes of a configuration file."""


@dataclass(frozen=True, slots=True)
class RobotSettings:
    """The settings of one simulated robot.

    Attributes:
        gateway: `ws://host:port/adapter` of the gateway.
        engine_id: leads every ref of this robot; unique behind its gateway.
        simulation: speeds, battery, visitor.
        network: how its streams use the network.
        credentials: for the gateway.
    """

    gateway: str = "ws://127.0.0.1:8765/adapter"
    engine_id: str = "robot"
    simulation: SimulationSettings = field(default_factory=SimulationSettings)
    network: NetworkSettings = field(default_factory=NetworkSettings)
    credentials: Credentials = NO_CREDENTIALS


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the robot."""
    defaults = RobotSettings()
    parser.add_argument("--gateway", default=defaults.gateway, metavar="URL", help="where it is (%(default)s)")
    add_credential_options(parser)
    parser.add_argument("--engine-id", default=defaults.engine_id, help="unique behind its gateway (%(default)s)")
    parser.add_argument(
        "--config", type=Path, metavar="FILE", help="TOML with the tables base and battery: speeds and limits"
    )
    base, battery = defaults.simulation.base, defaults.simulation.battery
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
    add_network_options(parser)


def read_settings(chosen: argparse.Namespace) -> RobotSettings:
    """Return the settings: each from its option, else from the configuration file, else its default.

    Raises:
        ValueError: one is wrong, or the file cannot be read; a sentence for a person.
    """
    base, battery = _of_file(chosen.config) if chosen.config is not None else (BaseSettings(), BatterySettings())
    base = _replaced(base, speed=chosen.max_speed, turn=chosen.max_turn)
    battery = _replaced(battery, charge=_share(chosen.battery), low=_share(chosen.battery_low))
    return RobotSettings(
        adapter_url(chosen.gateway),
        chosen.engine_id,
        SimulationSettings(base, battery, chosen.visitor),
        network_settings(chosen),
        credentials(chosen),
    )


def _share(percent: float | None) -> float | None:
    return None if percent is None else percent / 100


def _replaced(settings: Any, **options: float | None) -> Any:
    return replace(settings, **{name: value for name, value in options.items() if value is not None})


def _of_file(path: Path) -> tuple[BaseSettings, BatterySettings]:
    try:
        with path.open("rb") as file:
            text = file.read(_LARGEST + 1)
        if len(text) > _LARGEST:
            raise ValueError(f"--config: {path} is larger than {_LARGEST} bytes")
        tables = tomllib.loads(text.decode())
    except OSError as error:
        raise ValueError(f"--config: {path} cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise ValueError(f"--config: {path} is no TOML: {error}") from None
    unknown = tables.keys() - {"base", "battery"}
    if unknown:
        raise ValueError(f"--config: {path}: there is no table {min(unknown)!r}; there are base and battery")
    try:
        base, battery = _numbers("base", tables, BaseSettings), _numbers("battery", tables, BatterySettings)
        return BaseSettings(**base), BatterySettings(**battery)
    except ValueError as error:
        raise ValueError(f"--config: {path}: {error}") from None


def _numbers(name: str, tables: Mapping[str, Any], kind: type) -> dict[str, float]:
    """Return a table of the file, whose values must be numbers with the names of a class's fields."""
    table = tables.get(name, {})
    if not isinstance(table, dict):
        raise ValueError(f"{name} must be a table")
    known: Sequence[str] = [each.name for each in fields(kind)]
    for key, value in table.items():
        if key not in known:
            raise ValueError(f"{name}.{key} is not known; {name} has {', '.join(known)}")
        if not isinstance(value, int | float) or isinstance(value, bool):
            raise ValueError(f"{name}.{key} must be a number, not {value!r}")
    return {key: float(value) for key, value in table.items()}
