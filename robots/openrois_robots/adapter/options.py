"""Options and configuration file that the adapter of every robot has."""

import argparse
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, TypeVar, cast

from openrois_media.network_options import add_network_options, network_settings
from openrois_streaming.network.settings import NetworkSettings

from openrois.adapter.loading import add_component_option, load_components
from openrois.component.component import Component
from openrois.metrics.server import LOOPBACK, metrics_address
from openrois.transport.address import adapter_urls
from openrois.transport.credential_options import add_credential_options, credentials
from openrois.transport.credentials import NO_CREDENTIALS, Credentials

__all__ = [
    "AdapterSettings",
    "RobotTable",
    "add_adapter_options",
    "add_robot_option",
    "read_adapter_settings",
    "read_config",
    "read_table",
    "read_toml",
    "robot_address",
]

_D = TypeVar("_D")

_LARGEST: Final = 1 << 20
"""Bytes of a configuration file."""

_MOST_BITS: Final = 63
"""Of an integer."""

_TYPES: Final[Mapping[Any, tuple[tuple[type, ...], str]]] = MappingProxyType(
    {
        float: ((int, float), "a number"),
        int: ((int,), "an integer"),
        bool: ((bool,), "true or false"),
        str: ((str,), "text"),
    }
)
"""By the type of a field: what a value may be, and what it is called."""

_GATEWAY: Final = "ws://127.0.0.1:8765/adapter"


@dataclass(frozen=True, slots=True)
class AdapterSettings:
    """The settings that the adapter of every robot has.

    Attributes:
        engine_id: leads every ref of the robot; unique behind its gateway.
        gateways: `ws://host:port/adapter` of each gateway that it may serve, one at a time.
        network: how its streams use the network.
        credentials: for the gateways.
        metrics: host and port of the metrics for Prometheus; None for nowhere.
        components: the classes of those that the user adds.
    """

    engine_id: str
    gateways: tuple[str, ...] = (_GATEWAY,)
    network: NetworkSettings = field(default_factory=NetworkSettings)
    credentials: Credentials = NO_CREDENTIALS
    metrics: tuple[str, int] | None = None
    components: tuple[type[Component], ...] = ()


@dataclass(frozen=True, slots=True)
class RobotTable:
    """The table `robot` of the configuration file of a robot that is found by its address.

    Attributes:
        address: `HOST` or `HOST:PORT`; empty: `--robot` says it.
    """

    address: str = ""


def add_robot_option(parser: argparse.ArgumentParser, port: int) -> None:
    """Add `--robot`, the address of a robot; `port` is that of its API."""
    parser.add_argument(
        "--robot", metavar="HOST[:PORT]", help=f"where it is (port {port} unless given; robot.address of --config)"
    )


def robot_address(chosen: argparse.Namespace, table: RobotTable) -> str:
    """Return the address of `--robot`, else that of the configuration file.

    Raises:
        ValueError: there is none; a sentence for a person.
    """
    address: str = chosen.robot or table.address
    if not address:
        raise ValueError("--robot is missing: say where the robot is, as in --robot 192.168.1.20")
    return address


def add_adapter_options(parser: argparse.ArgumentParser, engine_id: str, tables: str) -> None:
    """Add the options.

    Args:
        parser: of the robot's command.
        engine_id: the default one.
        tables: of the configuration file, and what they hold, for the help: `base and battery: speeds and limits`.
    """
    parser.add_argument(
        "--gateway", default=_GATEWAY, metavar="URL[,URL]", help="where it is, or each of several (%(default)s)"
    )
    add_credential_options(parser)
    parser.add_argument("--engine-id", default=engine_id, help="unique behind its gateway (%(default)s)")
    parser.add_argument("--config", type=Path, metavar="FILE", help=f"TOML with the tables {tables}")
    parser.add_argument(
        "--metrics",
        metavar="[HOST:]PORT",
        help=f"serve figures for Prometheus there, at /metrics (without it nowhere; HOST is {LOOPBACK} unless given)",
    )
    add_component_option(parser)
    add_network_options(parser)
    parser.add_argument("--verbose", action="store_true", help="log more")
    parser.add_argument("--log-format", choices=("text", "json"), default="text", help="of log lines (%(default)s)")


def read_adapter_settings(chosen: argparse.Namespace) -> AdapterSettings:
    """Return the settings of the options.

    Raises:
        ValueError: one is wrong; a sentence for a person.
    """
    return AdapterSettings(
        chosen.engine_id,
        adapter_urls(chosen.gateway),
        network_settings(chosen),
        credentials(chosen),
        None if chosen.metrics is None else metrics_address(chosen.metrics),
        load_components(chosen.own_components),
    )


def read_config(path: Path | None, tables: Mapping[str, Callable[[str, Any], Any]]) -> Mapping[str, Any]:
    """Return the tables of a configuration file, each read by its function; what a file lacks is read as empty.

    Args:
        path: of the file (TOML); None: there is none.
        tables: by their name, how each is read: from the name and what stands there.

    Raises:
        ValueError: the file cannot be read, or something in it is wrong; a sentence for a person.
    """
    found = {} if path is None else read_toml(path)
    unknown = found.keys() - tables.keys()
    if unknown:
        raise ValueError(f"--config: {path}: there is no table {min(unknown)!r}; there are {_listed(tuple(tables))}")
    try:
        return MappingProxyType({name: read(name, found.get(name, {})) for name, read in tables.items()})
    except ValueError as error:
        raise ValueError(f"--config: {path}: {error}") from None


def read_table(kind: type[_D], name: str, table: Any) -> _D:
    """Return an instance of a dataclass for a table of the file, whose keys are its fields.

    Args:
        kind: has fields of `float`, `int`, `bool` and `str`.
        name: of the table.
        table: what the file has there.

    Raises:
        ValueError: a key is not known, or a value is not of its field's type, or out of bounds.
    """
    if not isinstance(table, dict):
        raise ValueError(f"{name} must be a table")
    known: Mapping[str, Any] = {each.name: each.type for each in fields(cast("Any", kind))}
    for key, value in table.items():
        if key not in known:
            raise ValueError(f"{name}.{key} is not known; {name} has {_listed(tuple(known))}")
        types, called = _TYPES[known[key]]
        if not isinstance(value, types) or (isinstance(value, bool) and bool not in types):
            raise ValueError(f"{name}.{key} must be {called}, not {value!r}")
        if isinstance(value, int) and value.bit_length() > _MOST_BITS:
            raise ValueError(f"{name}.{key} must be {called}, not one of {value.bit_length()} bits")
    return kind(**{key: float(value) if known[key] is float else value for key, value in table.items()})


def read_toml(path: Path) -> dict[str, Any]:
    """Return what stands in a configuration file.

    Raises:
        ValueError: it cannot be read, or is no TOML; a sentence for a person.
    """
    try:
        with path.open("rb") as file:
            text = file.read(_LARGEST + 1)
        if len(text) > _LARGEST:
            raise ValueError(f"--config: {path} is larger than {_LARGEST} bytes")
        return _loaded(path, text)
    except OSError as error:
        raise ValueError(f"--config: {path} cannot be read: {error.strerror}") from None
    except RecursionError:
        raise ValueError(f"--config: {path} is no TOML: it is nested too deeply") from None


def _loaded(path: Path, text: bytes) -> dict[str, Any]:
    try:
        return tomllib.loads(text.decode())
    except ValueError as error:  # of the text, of TOML, and of integers with thousands of digits
        raise ValueError(f"--config: {path} is no TOML: {error}") from None


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
