"""Command line options of the network side of streams."""

import argparse
from collections.abc import Sequence

from openrois_streaming.network.admission import AdmissionSettings
from openrois_streaming.network.interfaces import host_addresses
from openrois_streaming.network.session_limits import KEPT_FOR_OPERATORS, SessionLimits, kept_by_default
from openrois_streaming.network.settings import PROFILES, NetworkSettings, PortRange

__all__ = [
    "add_host_options",
    "add_network_options",
    "add_session_options",
    "host_arguments",
    "network_settings",
    "session_arguments",
]


def add_host_options(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    """Add the options of this machine's addresses and ports."""
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
    """Add all network options."""
    group = add_host_options(parser)
    group.add_argument("--public-address", metavar="IPV4", help="where a 1:1 NAT makes this machine known")
    group.add_argument(
        "--candidates", choices=tuple(PROFILES), default="lan", help="whose addresses are used (%(default)s)"
    )
    group.add_argument("--relay-only", action="store_true", help="media passes over TURN servers and no other way")
    defaults = AdmissionSettings()
    for option, text in (
        ("peer-packets", "packets a second that are admitted of one peer connection"),
        ("peer-bytes", "bytes a second that are admitted of one peer connection"),
        ("total-packets", "packets a second that are admitted of all peer connections"),
        ("total-bytes", "bytes a second that are admitted of all peer connections"),
    ):
        default = getattr(defaults, option.replace("-", "_"))
        group.add_argument(f"--{option}", type=int, default=default, metavar="N", help=f"{text} (%(default)s)")
    add_session_options(group)


def add_session_options(group: argparse._ActionsContainer) -> None:
    """Add the options that limit sessions."""
    defaults = SessionLimits()
    group.add_argument(
        "--applications",
        type=int,
        default=defaults.applications,
        metavar="N",
        help="applications that are streamed to at a time (%(default)s)",
    )
    group.add_argument(
        "--kept-for-operators",
        type=int,
        metavar="N",
        help=f"of these, places for applications that may bind (a quarter, at most {KEPT_FOR_OPERATORS})",
    )
    group.add_argument(
        "--answer-time",
        type=float,
        default=defaults.answer_time,
        metavar="SECONDS",
        help="for which an unanswered offer keeps a place that other applications want (%(default)s)",
    )


def session_limits(chosen: argparse.Namespace) -> SessionLimits:
    """Return the chosen session limits. Raises ValueError with a sentence."""
    kept = chosen.kept_for_operators
    if kept is None:
        kept = kept_by_default(chosen.applications)
    return SessionLimits(chosen.applications, kept, chosen.answer_time)


def session_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """Return the chosen session limits as arguments for another command. Raises ValueError with a sentence."""
    rules = session_limits(chosen)
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
    """Return the chosen settings. Raises ValueError with a sentence, also for an unknown interface."""
    settings = NetworkSettings(
        tuple(chosen.interface),
        chosen.udp_ports,
        chosen.public_address,
        chosen.relay_only,
        chosen.candidates,
        AdmissionSettings(chosen.peer_packets, chosen.peer_bytes, chosen.total_packets, chosen.total_bytes),
        session_limits(chosen),
    )
    host_addresses(settings.interfaces)
    return settings


def host_arguments(chosen: argparse.Namespace) -> Sequence[str]:
    """Return the options of `add_host_options` as given, as arguments for another command."""
    given = [argument for name in chosen.interface for argument in ("--interface", name)]
    ports = chosen.udp_ports
    return [*given, "--udp-ports", f"{ports.first}-{ports.last}"] if ports is not None else given
