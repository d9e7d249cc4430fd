"""`openrois gateway`: run a gateway until it is told to stop."""

import argparse
import asyncio
import logging
import signal
import sys
from collections.abc import Sequence
from pathlib import Path

import uvloop

from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.jsonrpc.session import CALL_TIMEOUT
from openrois.logs import set_up_logging

__all__ = ["main"]

_log = logging.getLogger(__name__)


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
    parser = argparse.ArgumentParser(prog="openrois gateway", description="The main HRI engine, on one port.")
    parser.add_argument("--host", default="127.0.0.1", help="loopback address to listen on (%(default)s)")
    parser.add_argument("--port", type=int, default=8765, help="TCP port (%(default)s)")
    parser.add_argument("--engine-id", default="gateway", help="the gateway's own id (%(default)s)")
    parser.add_argument(
        "--ice-server", action="append", default=[], metavar="URL", help="a STUN server for streams (repeatable)"
    )
    parser.add_argument(
        "--turn", action="append", default=[], metavar="URL", help="a TURN server for streams (repeatable)"
    )
    parser.add_argument(
        "--turn-secret-file", type=Path, metavar="FILE", help="holds what the TURN server's credentials are made with"
    )
    parser.add_argument(
        "--turn-ttl", type=int, default=600, metavar="SECONDS", help="how long each credential holds (%(default)s)"
    )
    parser.add_argument(
        "--adapter-timeout",
        type=float,
        default=CALL_TIMEOUT,
        metavar="SECONDS",
        help="how long an adapter has for each answer (%(default)s)",
    )
    parser.add_argument("--verbose", action="store_true", help="log more")
    chosen = parser.parse_args(arguments)
    set_up_logging(verbose=chosen.verbose)
    try:
        settings = GatewaySettings(
            host=chosen.host,
            port=chosen.port,
            engine_id=chosen.engine_id,
            ice_servers=tuple(chosen.ice_server),
            turn=tuple(chosen.turn),
            turn_secret=_secret(chosen.turn_secret_file),
            turn_ttl=chosen.turn_ttl,
            adapter_timeout=chosen.adapter_timeout,
        )
    except ValueError as error:
        parser.error(str(error))
    try:
        uvloop.run(_run(settings))
    except OSError as error:
        print(f"openrois gateway: {settings.host}:{settings.port}: {error.strerror or error}", file=sys.stderr)
        return 1
    return 0


def _secret(file: Path | None) -> str:
    """The first line of the file. Raises ValueError."""
    if file is None:
        return ""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is no text"
        raise ValueError(f"the secret of the TURN server cannot be read from {file}: {reason}") from None
    if file.stat().st_mode & 0o077:
        _log.warning("%s can be read by others on this machine; chmod 600 keeps the TURN server's secret", file)
    return text.partition("\n")[0].strip()


async def _run(settings: GatewaySettings) -> None:
    stopped = asyncio.Event()
    for name in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(name, stopped.set)
    async with run_gateway(settings) as gateway:
        print(f"listening {gateway.url}", flush=True)
        await stopped.wait()
