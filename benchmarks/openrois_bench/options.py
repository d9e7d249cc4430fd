"""Options of `openrois bench`: those of the gateway's benches, and those of all."""

import argparse
import asyncio
import os
import signal
import sys
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any, Final

import uvloop
from pydantic import BaseModel

from openrois.cli.command_line import CommandLine
from openrois_bench.errors import BenchFailed
from openrois_bench.gateway.events import EventsSettings, run_events
from openrois_bench.gateway.idle import IdleSettings, run_idle
from openrois_bench.gateway.rpc import RpcSettings, run_rpc
from openrois_bench.gateway.security import Security

__all__ = ["INTERRUPTED", "add_gateway_benches", "add_json", "carry_out", "count", "report_progress", "seconds"]

INTERRUPTED: Final = 130
"""The exit status of a command that Ctrl-C ended, as shells have it."""

_MOST: Final = 1000
_MOST_CONNECTIONS: Final = 100_000


def add_gateway_benches(benches: "argparse._SubParsersAction[CommandLine]") -> None:
    """Add `rpc`, `events` and `idle`."""
    rpc, events, idle = RpcSettings(), EventsSettings(), IdleSettings()
    told = "a query through the gateway, beside raw TCP and the bare websockets library (about 40 s)"
    options = benches.add_parser("rpc", help=told, description=told)
    _add_rounds(options, rpc.rounds, rpc.seconds)
    options.add_argument("--clients", type=count, default=rpc.clients, help="that ask at a time (%(default)s)")
    options.add_argument("--depth", type=count, default=rpc.depth, help="requests of each at a time (%(default)s)")
    options.set_defaults(
        loop_factory=uvloop.new_event_loop,
        run=lambda chosen: run_rpc(
            RpcSettings(
                rounds=chosen.rounds,
                seconds=chosen.seconds,
                clients=chosen.clients,
                depth=chosen.depth,
                security=Security(chosen.tls, chosen.auth),
            ),
            report_progress,
        ),
    )
    told = "events that many applications listen to (about 20 s)"
    options = benches.add_parser("events", help=told, description=told)
    _add_rounds(options, events.rounds, events.seconds)
    options.add_argument("--clients", type=count, default=events.clients, help="that listen (%(default)s)")
    options.set_defaults(
        loop_factory=uvloop.new_event_loop,
        run=lambda chosen: run_events(
            EventsSettings(
                rounds=chosen.rounds,
                seconds=chosen.seconds,
                clients=chosen.clients,
                security=Security(chosen.tls, chosen.auth),
            ),
            report_progress,
        ),
    )
    told = "connections on which nothing happens, over TLS (about 30 s)"
    options = benches.add_parser("idle", help=told, description=told)
    options.add_argument(
        "--connections", type=connections, default=idle.connections, help="that are open (%(default)s)"
    )
    options.add_argument("--seconds", type=seconds, default=idle.seconds, help="for which all are open (%(default)s)")
    add_json(options)
    options.set_defaults(
        loop_factory=uvloop.new_event_loop,
        run=lambda chosen: run_idle(
            IdleSettings(connections=chosen.connections, seconds=chosen.seconds), report_progress
        ),
    )


def _add_rounds(options: argparse.ArgumentParser, rounds: int, length: float) -> None:
    options.add_argument("--rounds", type=count, default=rounds, help="of all measurements (%(default)s)")
    options.add_argument("--seconds", type=seconds, default=length, help="of each under load (%(default)s)")
    options.add_argument("--tls", action="store_true", help="encrypt all connections to the gateway")
    options.add_argument("--auth", action="store_true", help="ask all clients for a token, and keep an audit trail")
    add_json(options)


def add_json(options: argparse.ArgumentParser) -> None:
    """Add the option that writes figures to a file."""
    options.add_argument("--json", type=_new_file, metavar="FILE", help="write everything that was measured to FILE")


def _number(convert: Callable[[str], float], text: str, most: int = _MOST) -> float:
    number = convert(text)
    if not 0 < number <= most:
        raise argparse.ArgumentTypeError(f"must be above 0 and at most {most}, not {text}")
    return number


def connections(text: str) -> int:
    """Read a number of connections."""
    return int(_number(int, text, _MOST_CONNECTIONS))


def seconds(text: str) -> float:
    """Read seconds."""
    return _number(float, text)


def count(text: str) -> int:
    """Read a number of things."""
    return int(_number(int, text))


def _new_file(text: str) -> Path:
    """Read a file name, and check before the bench that it can be written."""
    path = Path(text)
    if path.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
        raise argparse.ArgumentTypeError(f"{text} cannot be written: choose another file")
    return path


def report_progress(text: str) -> None:
    """Print the progress of a bench."""
    print(f"openrois bench: {text}", file=sys.stderr, flush=True)


def carry_out(chosen: argparse.Namespace) -> int:
    """Run the chosen bench, print its report, write it to the chosen file, and return the exit status.

    Args:
        chosen: the options; `run` among them makes the bench of them, and `loop_factory` what it runs on (None for
            asyncio's own).
    """
    try:
        with asyncio.Runner(loop_factory=chosen.loop_factory) as runner:
            report = runner.run(_until_interrupted(chosen.run(chosen)))
    except asyncio.CancelledError:
        return INTERRUPTED
    except BenchFailed as failure:
        report_progress(str(failure))
        return 1
    print(report)
    if chosen.json is not None:
        chosen.json.write_text(report.model_dump_json(indent=1) + "\n")
    return 0


async def _until_interrupted(bench: Coroutine[Any, Any, BaseModel]) -> BaseModel:
    running = asyncio.ensure_future(bench)
    for name in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(name, running.cancel)
    return await running
