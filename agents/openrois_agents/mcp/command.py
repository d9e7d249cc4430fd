"""`openrois mcp`: bodies as tools for agents, by the Model Context Protocol."""

import argparse
import asyncio
import gc
import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from openrois.auth.loopback import is_loopback
from openrois.cli.command_line import CommandLine, port_number
from openrois.extras import needing_extra
from openrois.observability.logs import set_up_logging
from openrois.transport.address import gateway_url
from openrois.transport.credential_options import add_credential_options, credentials
from openrois_agents.tools.settings import ACTING, IDLE, MOVEMENTS, ToolSettings

if TYPE_CHECKING:
    from openrois.client import Client

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
    if not chosen.http and (chosen.allow_host or chosen.allow_origin):
        parser.error("--allow-host and --allow-origin are for --http")
    if chosen.http and chosen.token_file:
        parser.error("--token-file is not for --http: each caller shows a token of its own")
    tools = ToolSettings(chosen.idle, frozenset(chosen.tools), chosen.movements, chosen.pictures)
    with needing_extra("mcp"):
        import mcp_types as _  # noqa: F401 - says at once what is missing
    # Standard output carries the protocol.
    set_up_logging(verbose=chosen.verbose)
    return _serve_http(chosen, url, tools) if chosen.http else _serve_stdio(chosen, url, tools)


def _serve_stdio(chosen: argparse.Namespace, url: str, tools: ToolSettings) -> int:
    # Nearly all that is made while modules are loaded stays: to look for garbage meanwhile takes a tenth of the time.
    gc.disable()
    from openrois_agents.mcp.stdio_server import serve_stdio

    gc.freeze()
    gc.enable()
    shown = credentials(chosen)
    if sys.stdin.isatty():
        print("openrois mcp: a host writes to standard input, a person hardly does; Ctrl-C ends it", file=sys.stderr)

    def make_client() -> "Client":
        from openrois.client import Client

        return Client(url, token=shown.token, ca_file=shown.ca_file)

    asyncio.run(serve_stdio(make_client, tools))
    return 0


def _serve_http(chosen: argparse.Namespace, url: str, tools: ToolSettings) -> int:
    from openrois.client import Client
    from openrois_agents.mcp.guard import host_rules
    from openrois_agents.mcp.http_server import PATH, HttpServer, listen

    host, port = chosen.http
    ca_file = credentials(chosen).ca_file
    try:
        listening = listen(host, port)
    except OSError as error:
        print(f"openrois mcp: cannot listen at {host}:{port}: {error.strerror or error}", file=sys.stderr)
        return 1
    rules = host_rules(host, chosen.allow_host, chosen.allow_origin)
    if not is_loopback(host):
        print("openrois mcp: tokens go over HTTP unencrypted: put a proxy with TLS before it", file=sys.stderr)
    print(f"listening http://{_address(host)}:{listening.getsockname()[1]}{PATH}", flush=True)

    def make_client(token: Callable[[], str] | None) -> Client:
        return Client(url, token=token, ca_file=ca_file)

    async def serve() -> None:
        server = HttpServer(rules, make_client, tools)
        with suppress(NotImplementedError):
            for name in (signal.SIGINT, signal.SIGTERM):
                asyncio.get_running_loop().add_signal_handler(name, server.end_serving)
        await server.serve(listening)

    asyncio.run(serve())
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
        "--http",
        type=_place,
        metavar="[HOST:]PORT",
        help="serve callers over HTTP there (127.0.0.1 unless HOST is given), not over standard input and output",
    )
    parser.add_argument(
        "--allow-host", action="append", default=[], metavar="NAME", help="a name by which callers call the server"
    )
    parser.add_argument(
        "--allow-origin", action="append", default=[], metavar="ORIGIN", help="a page that may use the server"
    )
    parser.add_argument(
        "--tools",
        type=_tools,
        default=list(ACTING),
        metavar="NAME[,NAME]",
        help=f"what tasks may have of {', '.join(ACTING)}; all unless given",
    )
    parser.add_argument("--no-pictures", dest="pictures", action="store_false", help="let no camera be looked through")
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


def _place(text: str) -> tuple[str, int]:
    """Read `PORT` or `HOST:PORT`."""
    host, _, port = text.rpartition(":")
    return host.strip("[]") or "127.0.0.1", port_number(port)


def _address(host: str) -> str:
    return f"[{host}]" if ":" in host else host
