"""`openrois avatar check`: check a game engine of your own against the engine link; exits with 0 if it passes."""

import asyncio
import secrets
import sys
from collections.abc import Sequence

from openrois.cli.command_line import CommandLine
from openrois_avatar.check.command_checks import Patience
from openrois_avatar.check.finding import Finding, Outcome, as_json, as_text, summary
from openrois_avatar.check.session import CannotStart, check_session
from openrois_avatar.link.address import ADDRESS_VARIABLE, SECRET_VARIABLE
from openrois_avatar.link.messages import LinkError
from openrois_avatar.options.link_options import add_link_options, link_secret
from openrois_avatar.options.settings import DEFAULT_LINK

__all__ = ["check", "main"]


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 if all checks passed, 1 if not, 2 for wrong usage."""
    parser = CommandLine(
        "openrois avatar check",
        description="Whether a game engine does what docs/reference/engine-link.md asks of it. Start it while this"
        f" waits, or let this run its COMMAND, which finds the address in {ADDRESS_VARIABLE} and the secret in"
        f" {SECRET_VARIABLE}.",
    )
    add_link_options(parser, otherwise=f"{DEFAULT_LINK}, with COMMAND a free port")
    parser.add_argument(
        "--wait", type=float, default=60.0, metavar="SECONDS", help="for the engine to connect (%(default)s)"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("command", nargs="*", metavar="COMMAND", help="the engine's, after --")
    chosen = parser.parse_args(arguments)
    try:
        secret = link_secret(chosen)
    except ValueError as error:
        parser.error(str(error))
    if chosen.command and not secret:
        secret = secrets.token_urlsafe(16)
    # Every engine supports TCP.
    address = chosen.link or ("tcp:127.0.0.1:0" if chosen.command else DEFAULT_LINK)
    try:
        return asyncio.run(check(address, secret, chosen.command, Patience(connect=chosen.wait), json=chosen.json))
    except (LinkError, CannotStart) as error:
        print(f"openrois avatar check: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130


async def check(address: str, secret: str, command: Sequence[str], patience: Patience, *, json: bool) -> int:
    """Check the engine that connects to an address, or is started; print the findings and return the exit status.

    Raises:
        LinkError: the address cannot be listened on.
        CannotStart: the command cannot be run.
    """
    found: list[Finding] = []
    async with check_session(address, secret, command, patience) as session:
        if not json and not command:
            print(f"waiting for an engine at {session.address}", flush=True)
        async for finding in session.findings():
            found.append(finding)
            if not json:
                print(as_text(finding), flush=True)
        told = None if session.hello is None else session.hello.to_json()
    if told is not None:
        del told["secret"]
    print(as_json(found, told) if json else f"\n{summary(found)}")
    return int(any(finding.outcome is Outcome.FAILED for finding in found))
