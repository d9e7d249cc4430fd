"""`openrois bench`: measure what matters on this machine, and say under which conditions."""

import argparse
import asyncio
import os
import signal
import sys
from collections.abc import Callable, Coroutine, Sequence
from pathlib import Path
from typing import Any, Final

from openrois_avatar.bench.browser import find_chromium
from openrois_avatar.bench.errors import BenchFailed
from openrois_avatar.bench.fanout import FanoutSettings, run_fanout
from openrois_avatar.bench.fanout_report import FanoutReport
from openrois_avatar.bench.latency import LatencySettings, run_latency
from openrois_avatar.bench.latency_report import LatencyReport

__all__ = ["main"]

INTERRUPTED: Final = 130
"""The exit status of a command that Ctrl-C ended, as shells have it."""

_MOST: Final = 1000


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status.

    Returns:
        0 when it measured, 1 when it could not, 2 for wrong usage, 130 when it was interrupted.
    """
    parser = argparse.ArgumentParser(prog="openrois bench", description="Measures on this machine.")
    benches = parser.add_subparsers(dest="bench", required=True, metavar="BENCH")
    latency, fanout = LatencySettings(), FanoutSettings()
    told = "from capture to viewer, over gateway and adapter: a measuring sink, and Chromium if there is one (a minute)"
    options = benches.add_parser("latency", help=told, description=told)
    options.add_argument(
        "--seconds", type=_seconds, default=latency.seconds, help="that each viewer plays (%(default)s)"
    )
    options.add_argument("--runs", type=_count, default=latency.runs, help="of connecting and resuming (%(default)s)")
    _add_json(options)
    told = "the sender's CPU with 1 to 8 viewers, beside aiortc alone (about 80 s)"
    options = benches.add_parser("fanout", help=told, description=told)
    options.add_argument("--seconds", type=_seconds, default=fanout.seconds, help="of each run (%(default)s)")
    options.add_argument("--rounds", type=_count, default=fanout.rounds, help="of all runs (%(default)s)")
    _add_json(options)
    chosen = parser.parse_args(arguments)
    if chosen.bench == "latency":
        settings = LatencySettings(chosen.seconds, chosen.runs, chromium=find_chromium())
        return _carry_out(run_latency(settings, _tell), chosen.json)
    return _carry_out(run_fanout(FanoutSettings(chosen.seconds, chosen.rounds), _tell), chosen.json)


def _add_json(options: argparse.ArgumentParser) -> None:
    options.add_argument("--json", type=_new_file, metavar="FILE", help="write everything that was measured to FILE")


def _number(convert: Callable[[str], float], text: str) -> float:
    number = convert(text)
    if not 0 < number <= _MOST:
        raise argparse.ArgumentTypeError(f"{text} is not above 0 and at most {_MOST}")
    return number


def _seconds(text: str) -> float:
    return _number(float, text)


def _count(text: str) -> int:
    return int(_number(int, text))


def _new_file(text: str) -> Path:
    """Find out now, and not after a minute, whether the figures can be written there."""
    path = Path(text)
    if path.is_dir() or not os.access(path if path.exists() else path.parent, os.W_OK):
        raise argparse.ArgumentTypeError(f"{text} cannot be written")
    return path


def _tell(text: str) -> None:
    print(f"openrois bench: {text}", file=sys.stderr, flush=True)


def _carry_out(bench: Coroutine[Any, Any, LatencyReport | FanoutReport], file: Path | None) -> int:
    try:
        report = asyncio.run(_until_interrupted(bench))
    except asyncio.CancelledError:
        return INTERRUPTED
    except BenchFailed as failure:
        _tell(str(failure))
        return 1
    print(report)
    if file is not None:
        file.write_text(report.model_dump_json(indent=1) + "\n")
    return 0


async def _until_interrupted(
    bench: Coroutine[Any, Any, LatencyReport | FanoutReport],
) -> LatencyReport | FanoutReport:
    running = asyncio.ensure_future(bench)
    for name in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(name, running.cancel)
    return await running
