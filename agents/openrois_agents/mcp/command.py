"""`openrois mcp`: bodies as tools for agents, by the Model Context Protocol."""

import argparse
import asyncio
from collections.abc import Sequence
from typing import Final

from openrois.cli.command_line import CommandLine
from openrois.extras import needing_extra
from openrois.transport.address import gateway_url
from openrois.transport.credential_options import add_credential_options, credentials
from openrois_agents.tools.abilities import ACTING
from openrois_agents.tools.settings import IDLE, MOVEMENTS, ToolSettings

__all__ = ["main"]

_EPILOG: Final = """\
Without --http it serves the host that started it, over standard input and output, and gives its body back when that
ends. With --http each caller shows a token of its own, which is passed to the gateway.
"""


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when it ended, 1 when it could not start, 2 for wrong usage."""
    parser = _parser()
    chosen = parser.parse_args(arguments)
    try:
        url = gateway_url(chosen.gateway)
    except ValueError as error:
        parser.error(f"--gateway: {error}")
    settings = ToolSettings(chosen.idle, frozenset(chosen.tools), chosen.movements)
    with needing_extra("mcp"):
        import mcp_types as _  # noqa: F401 - says at once what is missing
    _log_to_stderr(chosen.verbose)
    shown = credentials(chosen)
    from openrois.client import Client
    from openrois_agents.mcp.stdio_server import serve_stdio

    asyncio.run(serve_stdio(lambda: Client(url, token=shown.token, ca_file=shown.ca_file), settings))
    return 0


def _parser() -> CommandLine:
    parser = CommandLine(
        "openrois mcp",
        description="Serves bodies as tools for agents, by the Model Context Protocol.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--gateway", default="ws://127.0.0.1:8765/", metavar="URL", help="the gateway (%(default)s)")
    add_credential_options(parser)
    parser.add_argument(
        "--tools",
        type=_tools,
        default=list(ACTING),
        metavar="NAME[,NAME]",
        help=f"what tasks may have of {', '.join(ACTING)}; all unless given",
    )
    parser.add_argument(
        "--movements",
        type=_count,
        default=MOVEMENTS,
        metavar="N",
        help="movements a minute that a task may begin (%(default)s)",
    )
    parser.add_argument(
        "--idle",
        type=_seconds,
        default=IDLE,
        metavar="SECONDS",
        help="without a call, after which a body is given back (%(default)g)",
    )
    parser.add_argument("--verbose", action="store_true", help="log more")
    return parser


def _tools(text: str) -> list[str]:
    names = text.split(",")
    if unknown := [name for name in names if name not in ACTING]:
        raise argparse.ArgumentTypeError(f"there is no {unknown[0]!r}: there are {', '.join(ACTING)}")
    return names


def _count(text: str) -> int:
    if not (text.isascii() and text.isdigit() and 0 < int(text) <= 6_000):
        raise argparse.ArgumentTypeError(f"must be 1 to 6000, not {text[:40]}")
    return int(text)


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 1 <= seconds <= 86_400:
        raise argparse.ArgumentTypeError(f"must be 1 to 86400 seconds, not {text[:40]}")
    return seconds


def _log_to_stderr(verbose: bool) -> None:
    """Log to standard error: standard output carries the protocol."""
    from openrois.observability.logs import set_up_logging

    set_up_logging(verbose=verbose)
