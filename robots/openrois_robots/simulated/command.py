"""`openrois robot simulated`: run the simulated robot until a signal stops it."""

import sys
from collections.abc import Sequence
from contextlib import AsyncExitStack

import uvloop
from openrois_media.running import prepare_process
from openrois_streaming.aiortc_internals.trial import UnsupportedLibrary
from openrois_streaming.clock import SystemClock

from openrois.adapter.process import AdapterProcess, run_until_stopped
from openrois.cli.command_line import CommandLine
from openrois.errors import BadParameter
from openrois.observability.logs import set_up_logging
from openrois_robots.simulated.adapter import hosted_robot, simulated_robot
from openrois_robots.simulated.options import RobotSettings, add_options, read_settings

__all__ = ["main"]

_NAME = "openrois robot simulated"


def main(arguments: Sequence[str]) -> int:
    """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
    parser = CommandLine(_NAME, description="A mobile robot in simulated rooms, behind a gateway.")
    add_options(parser)
    parser.add_argument("--verbose", action="store_true", help="log more")
    chosen = parser.parse_args(arguments)
    try:
        settings = read_settings(chosen)
    except ValueError as error:
        parser.error(str(error))
    try:
        # Both are read again whenever they are needed; an error now is most likely a mistake.
        settings.credentials.newest(), settings.credentials.context(settings.gateway)
    except ValueError as error:
        print(f"{_NAME}: {error}", file=sys.stderr)
        return 1
    set_up_logging(verbose=chosen.verbose)
    prepare_process()
    try:
        uvloop.run(run_until_stopped(_serve(settings)))
    except (UnsupportedLibrary, BadParameter) as error:
        print(f"{_NAME}: {error}", file=sys.stderr)
        return 1
    return 0


async def _serve(settings: RobotSettings) -> None:
    clock = SystemClock()
    async with AsyncExitStack() as stack:
        robot = await stack.enter_async_context(simulated_robot(settings.engine_id, settings.simulation, clock))
        host = await stack.enter_async_context(hosted_robot(settings.engine_id, robot, clock, settings.network))
        await AdapterProcess(settings.engine_id).serve(host, settings.gateway, settings.credentials)
