"""The network side of streams as options of a command."""

import argparse
from collections.abc import Sequence

from openrois_streaming.network.admission import AdmissionSettings
from openrois_streaming.network.interfaces import host_addresses
from openrois_streaming.network.places import KEPT_FOR_OPERATORS, PlaceRules, kept_places
from openrois_streaming.network.settings import PROFILES, NetworkSettings, PortRange

__all__ = [
    "add_host_options",
    "add_network_options",
    "add_place_options",
    "host_arguments",
    "network_settings",
    "place_arguments",
]


def add_host_options(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add what concerns this machine's own addresses and ports."""
    group = parser.add_argument_group("network of the streams")
    group.add_argument(
        "--interface",
        action="append",
        default=[],
        metavar="NAME",
        help="a network interface for media, by name or address (repeatable; all but loopback)",
    )
    group.add_argument("--udp-ports", type=_ports, metavar="FIRST-LAST", help="the UDP ports that media may use (any)")
    return group


def add_network_options(parser: argparse.ArgumentParser) -> None:
    """Add all of it."""
    group = add_host_options(parser)
    group.add_argument("--public-address", metavar="IPV4", help="where a 1:1 NAT makes this machine known")
    group.add_argument(
        "--candidates", choices=tuple(PROFILES), default="lan", help="whose addresses are used (%(default)s)"
    )
    group.add_argument("--relay-only", action="store_true", help="media passes over TURN servers and no other way")
    defaults = AdmissionSettings()
    for option, told in (
        ("peer-packets", "packets a second that are admitted of one peer connection"),
        ("peer-bytes", "bytes a second that are admitted of one peer connection"),
        ("total-packets", "packets a second that are admitted of all peer connections"),
        ("total-bytes", "bytes a second that are admitted of all peer connections"),
    ):
        default = getattr(defaults, option.replace("-", "_"))
        group.add_argument(f"--{option}", type=int, default=default, metavar="N", help=f"{told} (%(default)s)")
    add_place_options(group)


def add_place_options(group: argparse._ActionsContainer) -> None:
    """Add how many applications are streamed to, and for whom places are kept."""
    places = PlaceRules()
    group.add_argument(
        "--applications",
        type=int,
        default=places.applications,
        metavar="N",
        help="applications that are streamed to at a time (%(default)s)",
    )
    group.add_argument(
        "--kept-for-operators",
        type=int,
        metavar="N",
        help=f"of these, places that those leave free that may not bind (a quarter, at most {KEPT_FOR_OPERATORS})",
    )
    group.add_argument(
        "--answer-time",
        type=float,
        default=places.answer_time,
        metavar="SECONDS",
        help="for which an unanswered offer holds a place that others want (%(default)s)",
    )


def place_rules(chosen: argparse.Namespace) -> PlaceRules:
    """Return what was chosen of `add_place_options`. Raises ValueError with a sentence."""
    kept = chosen.kept_for_operators
    if kept is None:
        kept = kept_places(chosen.applications)
    return PlaceRules(chosen.applications, kept, chosen.answer_time)


def place_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """Return the options of `add_place_options` for another command. Raises ValueError with a sentence."""
    rules = place_rules(chosen)
    given = {
        "--applications": rules.applications,
        "--kept-for-operators": rules.kept_for_operators,
        "--answer-time": rules.answer_time,
    }
    return [argument for option, value in given.items() for argument in (option, str(value))]


def _ports(text: str) -> PortRange:
    try:
        return PortRange.parse(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def network_settings(chosen: argparse.Namespace) -> NetworkSettings:
    """What was chosen. Raises ValueError with a sentence, also for an interface that is not there."""
    settings = NetworkSettings(
        tuple(chosen.interface),
        chosen.udp_ports,
        chosen.public_address,
        chosen.relay_only,
        chosen.candidates,
        AdmissionSettings(chosen.peer_packets, chosen.peer_bytes, chosen.total_packets, chosen.total_bytes),
        place_rules(chosen),
    )
    host_addresses(settings.interfaces)
    return settings


def host_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """The options of `add_host_options` as they were given, for another command."""
    given = [argument for name in chosen.interface for argument in ("--interface", name)]
    ports = chosen.udp_ports
    return [*given, "--udp-ports", f"{ports.first}-{ports.last}"] if ports is not None else given
