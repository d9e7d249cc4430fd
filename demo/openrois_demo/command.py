"""`openrois demo`: run a gateway and an avatar, as two supervised processes, until a signal stops them."""

import asyncio
import errno
import signal
import socket
import sys
from collections.abc import Awaitable, Callable, Coroutine, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

from openrois_avatar.options.engine_options import add_engine_options, engine_arguments
from openrois_avatar.options.link_options import add_facade_option, add_link_options, link_arguments
from openrois_media.network_options import add_host_options, add_session_options, host_arguments, session_arguments

from openrois.auth.principal import Role
from openrois.cli.command_line import CommandLine, port_number
from openrois.observability.logs import set_up_logging
from openrois.transport.credential_options import add_credential_options, credential_arguments, credentials
from openrois.transport.websocket import dial
from openrois_demo.access import add_access_options, demo_access
from openrois_demo.program import Program, ProgramFailed
from openrois_demo.watchdog import Watchdog

__all__ = ["main"]

_START_TIMEOUT: Final = 60.0


@dataclass(frozen=True, slots=True)
class _Demo:
    """The parts of a demo.

    Attributes:
        gateway: its gateway.
        avatar: the avatar behind it.
        watchdog: restarts them when they hang.
        page: URL of its page.
        keep_token: renews the avatar's token until cancelled.
    """

    gateway: Program
    avatar: Program
    watchdog: Watchdog
    page: str
    keep_token: Callable[[], Coroutine[object, object, None]]


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
    parser = CommandLine("openrois demo", description="A live avatar on a page of this machine.")
    parser.add_argument("--port", type=port_number, default=8765, help="TCP port of the page (%(default)s)")
    add_engine_options(parser)
    add_link_options(parser, when=" if it is external or a facade")
    add_facade_option(parser)
    add_host_options(parser)
    add_session_options(parser)
    add_credential_options(parser)
    add_access_options(parser)
    parser.add_argument("--verbose", action="store_true", help="log more")
    chosen = parser.parse_args(arguments)
    try:
        access = demo_access(chosen)
        of_engine = (*engine_arguments(chosen), *session_arguments(chosen))
    except ValueError as error:
        parser.error(str(error))
    set_up_logging(verbose=chosen.verbose)
    if not _is_free(access.host, chosen.port):
        print(
            f"openrois demo: port {chosen.port} is in use, perhaps by another demo; choose another one with --port",
            file=sys.stderr,
        )
        return 1
    more = ("--verbose",) if chosen.verbose else ()
    with access.token_file() as issued:
        shown = credentials(chosen)
        if issued is not None:
            chosen.token_file = issued
            shown = replace(shown, token=partial(access.token, Role.VIEWER))
        url = access.url("ws", chosen.port)
        of_avatar = (*link_arguments(chosen), *host_arguments(chosen), *credential_arguments(chosen), *more)
        gateway = ("gateway", "--port", str(chosen.port), "--drain", "0", *access.gateway_arguments(), *more)
        avatar = ("avatar", "--gateway", f"{url}adapter", *of_engine, *of_avatar)
        demo = _Demo(
            Program(gateway, announces="listening "),
            Program(avatar, announces="ready "),
            Watchdog(url, connect=partial(dial, credentials=shown)),
            access.url("http", chosen.port),
            partial(access.keep_token, issued),
        )
        return asyncio.run(_run(demo))


def _is_free(host: str, port: int) -> bool:
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as probe:
        # As the gateway does: a port with connections in TIME_WAIT counts as free.
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            return error.errno != errno.EADDRINUSE
    return True


async def _run(demo: _Demo) -> int:
    running = asyncio.ensure_future(_keep_running(demo))
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


async def _keep_running(demo: _Demo) -> None:
    async with asyncio.TaskGroup() as tasks:
        tasks.create_task(demo.keep_token())
        for program in (demo.gateway, demo.avatar):
            tasks.create_task(program.keep_running())
            await _in_time(program.ready.wait(), f"{program.name} is not ready")
        tasks.create_task(demo.watchdog.watch(demo.gateway, demo.avatar))
        await _in_time(demo.watchdog.until_there(), "no avatar has connected to the gateway")
        print(f"ready {demo.page}", flush=True)


async def _in_time(step: Awaitable[object], complaint: str) -> None:
    try:
        async with asyncio.timeout(_START_TIMEOUT):
            await step
    except TimeoutError:
        raise ProgramFailed(f"{complaint} after {_START_TIMEOUT:.0f} s; --verbose logs more") from None
