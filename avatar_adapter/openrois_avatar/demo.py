"""`openrois demo`: run a gateway and an avatar, as two processes that are watched over, until told to stop."""

import argparse
import asyncio
import signal
import socket
import sys
from collections.abc import Awaitable, Sequence
from functools import partial
from typing import Final

from openrois.command_line import CommandLine
from openrois.logs import set_up_logging
from openrois.transport.credential_options import add_credential_options, credential_arguments, credentials
from openrois.transport.websocket import dial
from openrois_avatar.attendance import Attendance
from openrois_avatar.link_options import add_facade_option, add_link_options, link_arguments
from openrois_avatar.network_options import add_host_options, host_arguments
from openrois_avatar.process import Program, ProgramFailed
from openrois_avatar.settings import ENGINES

__all__ = ["main"]

_HOST: Final = "127.0.0.1"
_START_TIMEOUT: Final = 60.0


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
    parser = CommandLine("openrois demo", description="A live avatar on a page of this machine.")
    parser.add_argument("--port", type=_port, default=8765, help="TCP port of the page (%(default)s)")
    parser.add_argument("--engine", choices=ENGINES, default="auto", help="what renders the avatar (%(default)s)")
    add_link_options(parser, when=" if it is external or a facade")
    add_facade_option(parser)
    add_host_options(parser)
    add_credential_options(parser)
    parser.add_argument("--verbose", action="store_true", help="log more")
    chosen = parser.parse_args(arguments)
    set_up_logging(verbose=chosen.verbose)
    if not _is_free(chosen.port):
        print(f"openrois demo: port {chosen.port} is taken; is a demo running already? Try --port.", file=sys.stderr)
        return 1
    more = ("--verbose",) if chosen.verbose else ()
    passed_on = (*link_arguments(chosen), *host_arguments(chosen), *credential_arguments(chosen), *more)
    attendance = Attendance(f"ws://{_HOST}:{chosen.port}/", connect=partial(dial, credentials=credentials(chosen)))
    return asyncio.run(_run(chosen.port, chosen.engine, more, passed_on, attendance))


def _port(text: str) -> int:
    if not (text.isascii() and text.isdigit() and 0 < int(text) < 1 << 16):
        raise argparse.ArgumentTypeError(f"{text!r} is not a port from 1 to 65535")
    return int(text)


def _is_free(port: int) -> bool:
    with socket.socket() as probe:
        # As the gateway will: a port whose last connections are still winding down counts as free.
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((_HOST, port))
        except OSError:
            return False
    return True


async def _run(port: int, engine: str, more: Sequence[str], of_avatar: Sequence[str], attendance: Attendance) -> int:
    gateway = Program(("gateway", "--port", str(port), "--drain", "0", *more), announces="listening ")
    avatar = Program(
        ("avatar", "--gateway", f"ws://{_HOST}:{port}/adapter", "--engine", engine, *of_avatar), announces="ready "
    )
    running = asyncio.ensure_future(_keep_running(gateway, avatar, attendance, f"http://{_HOST}:{port}/"))
    for name in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(name, running.cancel)
    try:
        await running
    except asyncio.CancelledError:
        return 0
    except ExceptionGroup as group:
        failure: Exception = group
        while isinstance(failure, ExceptionGroup):
            failure = failure.exceptions[0]
        print(f"openrois demo: {failure}", file=sys.stderr)
    return 1


async def _keep_running(gateway: Program, avatar: Program, attendance: Attendance, url: str) -> None:
    async with asyncio.TaskGroup() as tasks:
        for program in (gateway, avatar):
            tasks.create_task(program.keep_running())
            await _in_time(program.ready.wait(), f"{program.name} is not ready")
        tasks.create_task(attendance.watch(gateway, avatar))
        await _in_time(attendance.until_there(), "no avatar has come to the gateway")
        print(f"ready {url}", flush=True)


async def _in_time(step: Awaitable[object], complaint: str) -> None:
    try:
        async with asyncio.timeout(_START_TIMEOUT):
            await step
    except TimeoutError:
        raise ProgramFailed(f"{complaint} after {_START_TIMEOUT:.0f} s") from None
