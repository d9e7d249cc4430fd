"""`openrois doctor`: look at this machine, or what gateways share, and say what to change; 0 where it works."""

import asyncio
import sys
import time
from collections.abc import AsyncIterator, Sequence
from pathlib import Path

from openrois_media.network_options import add_network_options, network_settings
from openrois_signaling.messages import IceServer
from openrois_signaling.turn import turn_credential
from openrois_streaming.network.servers import read_servers
from openrois_streaming.network.settings import NetworkSettings

from openrois.cli.command_line import CommandLine, port_number
from openrois.extras import missing_modules
from openrois_demo.doctor import machine
from openrois_demo.doctor.cluster_options import add_cluster_options, shared_parts
from openrois_demo.doctor.extras import extras
from openrois_demo.doctor.finding import Finding, Level, as_json, as_text, exit_status, summary

__all__ = ["main"]


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 if what it looks at will work, 1 if not, 2 for wrong usage."""
    parser = CommandLine(
        "openrois doctor",
        description="What of the media path works here, and what to change where it does not. With --cluster and "
        "--store it looks at NATS, PostgreSQL and gateways in place of that, and changes nothing there.",
    )
    parser.add_argument("--port", type=port_number, default=8765, help="the gateway's TCP port (%(default)s)")
    parser.add_argument("--ice-server", action="append", default=[], metavar="URL", help="a STUN server to ask")
    parser.add_argument("--turn", action="append", default=[], metavar="URL", help="a TURN server to ask")
    parser.add_argument("--turn-secret-file", type=Path, metavar="FILE", help="holds its secret, as the gateway's does")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    add_network_options(parser)
    add_cluster_options(parser)
    chosen = parser.parse_args(arguments)
    try:
        if chosen.cluster or chosen.store:
            from openrois_demo.doctor.cluster import cluster

            found = cluster(shared_parts(chosen))
            return asyncio.run(_examine(found, "several gateways", json=chosen.json))
        # Without the libraries of the media plane nothing can be said of its network.
        settings = None if missing_modules("streaming") else network_settings(chosen)
        servers = _servers(chosen.ice_server, chosen.turn, chosen.turn_secret_file)
    except ValueError as error:
        parser.error(str(error))
    return asyncio.run(_examine(_findings(settings, servers, chosen.port), "streams", json=chosen.json))


def _servers(stun: Sequence[str], turn: Sequence[str], secret_file: Path | None) -> list[IceServer]:
    """Return the servers to try. Raises ValueError with a sentence."""
    if bool(turn) != (secret_file is not None):
        raise ValueError("--turn and --turn-secret-file must be given together")
    given = [IceServer(urls=(url,)) for url in stun]
    if secret_file is not None:
        try:
            secret = secret_file.read_text(encoding="utf-8").partition("\n")[0].strip()
        except (OSError, UnicodeDecodeError) as error:
            why = error.strerror if isinstance(error, OSError) else "it is no text"
            raise ValueError(f"the secret cannot be read from {secret_file}: {why}") from None
        username, credential = turn_credential(secret, int(time.time()) + 60, "doctor")
        given.append(IceServer(urls=tuple(turn), username=username, credential=credential))
    return given


async def _examine(findings: AsyncIterator[Finding], subject: str, *, json: bool) -> int:
    found: list[Finding] = []
    async for finding in findings:
        found.append(finding)
        if not json:
            print(as_text(finding, colour=sys.stdout.isatty()), flush=True)
    print(as_json(found) if json else f"\n{summary(found, subject)}")
    return exit_status(found)


async def _findings(
    settings: NetworkSettings | None, servers: Sequence[IceServer], port: int
) -> AsyncIterator[Finding]:
    for finding in extras():
        yield finding
    if settings is not None:
        from openrois_demo.doctor import libraries

        yield await libraries.libraries()
        yield libraries.codecs()
    if not missing_modules("avatar"):
        from openrois_demo.doctor import avatar

        yield avatar.game_engine()
        yield avatar.voice()
        yield avatar.hearing()
        yield avatar.vision()
    if not missing_modules("robot"):
        from openrois_demo.doctor.robot import simulated_robot

        yield simulated_robot()
    yield machine.browser()
    yield machine.port(port)
    yield machine.clock()
    yield machine.load()
    if settings is not None:
        async for finding in _media_findings(settings, servers):
            yield finding


async def _media_findings(settings: NetworkSettings, servers: Sequence[IceServer]) -> AsyncIterator[Finding]:
    from openrois_demo.doctor import network
    from openrois_demo.doctor.media import media

    if not settings.relay_only:
        yield network.interfaces(settings)
        yield network.udp_ports(settings)
    known = read_servers(servers)
    way = network.candidates(settings, known)
    yield way
    for finding in await network.servers(known):
        yield finding
    if way.level is Level.FAIL:
        yield Finding(Level.FAIL, "media", "not tried, for it has no way to go")
    else:
        for finding in await media(settings, servers):
            yield finding
