"""`openrois demo`: run a gateway with an avatar, and a robot if wanted, as processes, until a signal stops them."""

import argparse
import asyncio
import errno
import os
import signal
import socket
import sys
from collections.abc import Awaitable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Final

from openrois_agents.mind.options import add_mind_options, mind_arguments, mind_choice
from openrois_agents.mind.phrases import make_phrases
from openrois_agents.tools.names import Vocabulary
from openrois_avatar.options.engine_options import add_engine_options, engine_arguments
from openrois_avatar.options.link_options import add_facade_option, add_link_options, link_arguments
from openrois_body.speech_options import (
    add_ears_options,
    add_voice_options,
    ears_arguments,
    ears_choice,
    voice_arguments,
    voice_choice,
)
from openrois_media.network_options import add_host_options, add_session_options, host_arguments, session_arguments

from openrois.adapter.loading import add_component_option, component_arguments, load_components
from openrois.cli.command_line import CommandLine, port_number
from openrois.observability.logs import set_up_logging
from openrois.transport.credential_options import add_credential_options, credential_arguments, credentials
from openrois.transport.credentials import TOKEN_FILE_VARIABLE
from openrois.transport.websocket import dial
from openrois_demo.access import add_access_options, demo_access
from openrois_demo.life_signs import LifeSigns
from openrois_demo.program import Program, ProgramFailed
from openrois_demo.tokens import DemoTokens
from openrois_demo.watchdog import Watchdog

__all__ = ["main"]

_START_TIMEOUT: Final = 60.0
_EXAMPLES: Final = 8
"""Sentences that are named when a demo with a mind is ready."""
_AVATAR, _ROBOT = "avatar", "robot"
"""The engine ids of the bodies."""


@dataclass(frozen=True, slots=True)
class _Demo:
    """The parts of a demo.

    Attributes:
        gateway: its gateway.
        adapters: the bodies behind it, by their engine ids.
        watchdog: restarts them when they hang.
        page: URL of its page.
        tokens: of its adapters, and of programs.
        mind: converses with visitors; None where there is none.
        signs: of life, of the mind.
        can_be_said: to it, as a line.
    """

    gateway: Program
    adapters: Mapping[str, Program]
    watchdog: Watchdog
    page: str
    tokens: DemoTokens
    mind: Program | None
    signs: LifeSigns
    can_be_said: str


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
    parser = CommandLine("openrois demo", description="A live avatar on a page of this machine, and a robot beside it.")
    parser.add_argument("--port", type=port_number, default=8765, help="TCP port of the page (%(default)s)")
    parser.add_argument(
        "--with",
        dest="beside",
        action="append",
        choices=(_ROBOT,),
        default=[],
        help="puts a simulated robot beside the avatar (`openrois robot simulated --help`)",
    )
    add_engine_options(parser)
    add_link_options(parser, when=" if it is external or a facade")
    add_facade_option(parser)
    add_component_option(parser)
    parser.add_argument("--mind", action="store_true", help="lets the bodies converse with visitors (`openrois mind`)")
    add_mind_options(parser)
    add_voice_options(parser)
    add_ears_options(parser)
    add_host_options(parser)
    add_session_options(parser)
    add_credential_options(parser)
    add_access_options(parser)
    parser.add_argument("--verbose", action="store_true", help="log more")
    chosen = parser.parse_args(arguments)
    try:
        access = demo_access(chosen)
        of_engine = (*engine_arguments(chosen), *session_arguments(chosen))
        # What is wrong is said here, once, and not by each body.
        for read in (voice_choice, ears_choice):
            read(chosen)
        load_components(chosen.own_components)
        of_mind = mind_arguments(chosen)
        if not chosen.mind and of_mind != mind_arguments(parser.parse_args([])):
            raise ValueError("there are options of a mind: add --mind")
        mind_choice(chosen)
        of_avatar = (*component_arguments(chosen), *voice_arguments(chosen), *ears_arguments(chosen))
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
    engine_ids = (_AVATAR, *dict.fromkeys(chosen.beside))
    with DemoTokens.issued(access.key, engine_ids) as tokens:
        shown = replace(credentials(chosen), token=tokens.viewer if access.key is not None else None)
        # Its programs show the tokens that it issues, and none that is for another gateway.
        os.environ.pop(TOKEN_FILE_VARIABLE, None)
        url = access.url("ws", chosen.port)
        gateway = ("gateway", "--port", str(chosen.port), "--drain", "0", *access.gateway_arguments(tokens.key), *more)
        bodies = {
            _AVATAR: ("avatar", *of_engine, *of_avatar, *link_arguments(chosen)),
            _ROBOT: (
                *("robot", "simulated", *(("--visitor",) if chosen.visitor else ())),
                *(*session_arguments(chosen), *voice_arguments(chosen)),
            ),
        }
        signs = LifeSigns(tokens.folder / "mind.signs")
        demo = _Demo(
            Program(gateway, announces="listening "),
            {
                engine_id: Program(
                    (
                        *bodies[engine_id],
                        *("--gateway", f"{url}adapter"),
                        *host_arguments(chosen),
                        *_credentials(chosen, tokens.adapters.get(engine_id)),
                        *more,
                    ),
                    announces="ready ",
                )
                for engine_id in engine_ids
            },
            Watchdog(url, engine_ids, connect=partial(dial, credentials=shown)),
            access.url("http", chosen.port),
            tokens,
            _mind(chosen, url, (*_credentials(chosen, tokens.programs["agent"]), *of_mind, *more), signs),
            signs,
            _can_be_said(chosen),
        )
        return asyncio.run(_run(demo))


def _mind(chosen: argparse.Namespace, url: str, options: Sequence[str], signs: LifeSigns) -> Program | None:
    """Return the program that converses with visitors, where it is wanted."""
    if not chosen.mind:
        return None
    return Program(("mind", "--gateway", url, *options), announces="ready ", environment=signs.environment)


def _can_be_said(chosen: argparse.Namespace) -> str:
    """Return what can be said to the mind, in a line."""
    wake_word = f"{chosen.wake_word}, " if chosen.wake_word else ""
    if chosen.llm_url is not None:
        return f"say what you like{f', behind {chosen.wake_word}' if wake_word else ''}"
    return f"say: {'; '.join(f'{wake_word}{each}' for each in make_phrases(Vocabulary()).examples[:_EXAMPLES])}"


def _credentials(chosen: argparse.Namespace, token_file: Path | None) -> Sequence[str]:
    """Return the options for an adapter, with the token that was issued to it, if one was."""
    return credential_arguments(argparse.Namespace(**{**vars(chosen), "token_file": token_file}))


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
        tasks.create_task(demo.tokens.keep())
        for program in (demo.gateway, *demo.adapters.values()):
            tasks.create_task(program.keep_running())
            await _in_time(program.ready.wait(), f"{program.name} is not ready")
        tasks.create_task(demo.watchdog.watch(demo.gateway, demo.adapters))
        await _in_time(demo.watchdog.until_there(), f"{' or '.join(demo.adapters)} has not connected to the gateway")
        print(f"ready {demo.page}", flush=True)
        for rank, path in demo.tokens.programs.items():
            print(f"for a program, as {rank}: {TOKEN_FILE_VARIABLE}={path}", flush=True)
        if demo.mind is not None:
            await _keep_conversing(demo.mind, demo.signs, demo.can_be_said)


async def _keep_conversing(mind: Program, signs: LifeSigns, can_be_said: str) -> None:
    """Keep a mind running. It ends before the gateway does, where it gives its body back and puts grammars back."""
    async with asyncio.TaskGroup() as tasks:
        tasks.create_task(signs.watch(mind))
        tasks.create_task(mind.keep_running())
        await _in_time(mind.ready.wait(), f"{mind.name} is not ready")
        print(can_be_said, flush=True)


async def _in_time(step: Awaitable[object], complaint: str) -> None:
    try:
        async with asyncio.timeout(_START_TIMEOUT):
            await step
    except TimeoutError:
        raise ProgramFailed(f"{complaint} after {_START_TIMEOUT:.0f} s; --verbose logs more") from None
