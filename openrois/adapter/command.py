"""The command line of an adapter: the addresses of its gateways, and the credentials for them."""

import argparse
from collections.abc import Sequence

from openrois.adapter.running import GATEWAY, GATEWAY_VARIABLE, run
from openrois.cli.command_line import CommandLine
from openrois.component.component import Component
from openrois.transport.address import adapter_urls
from openrois.transport.credential_options import add_credential_options

__all__ = ["adapter_options", "main", "read_options"]


def main(*components: Component, engine_id: str, arguments: Sequence[str] | None = None) -> None:
    """Serve components as `run` does, with the options of the command line; `--help` lists them.

    Args:
        components: each with a name of its own.
        engine_id: unique behind its gateway; leads every component_ref, unless `--engine-id` names another.
        arguments: of the command line; those of the process unless given.

    Raises:
        SystemExit: the options are wrong, or help was asked for.
    """
    chosen = read_options(adapter_options(components, engine_id), arguments)
    run(
        *components,
        engine_id=chosen.engine_id,
        gateway=chosen.gateway,
        token_file=chosen.token_file,
        ca_file=chosen.ca_file,
        verbose=chosen.verbose,
    )


def adapter_options(components: Sequence[Component], engine_id: str, *, also: Sequence[str] = ()) -> CommandLine:
    """Return a command line with the options of every adapter.

    Args:
        components: that it serves.
        engine_id: its default.
        also: what it serves besides, for its help.
    """
    offered = ", ".join([*(f"{each.profile.name} ({each.profile.identifier.code})" for each in components), *also])
    parser = CommandLine(None, description=f"An adapter with {offered}. It serves its gateway until Ctrl-C ends it.")
    parser.add_argument(
        "--gateway",
        metavar="URL[,URL]",
        help=f"where the gateway takes adapters, or each of several ({GATEWAY_VARIABLE}, or {GATEWAY})",
    )
    parser.add_argument(
        "--engine-id", default=engine_id, metavar="ID", help="leads its component_refs; unique there (%(default)s)"
    )
    add_credential_options(parser)
    parser.add_argument("--verbose", action="store_true", help="log more")
    return parser


def read_options(parser: CommandLine, arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the chosen options.

    Raises:
        SystemExit: they are wrong, or help was asked for.
    """
    chosen = parser.parse_args(arguments)
    try:
        if chosen.gateway is not None:
            adapter_urls(chosen.gateway)
    except ValueError as error:
        parser.error(f"--gateway: {error}")
    return chosen
