"""The command of one robot: options, logs, metrics, health, and its adapter until a signal stops it."""

import argparse
import sys
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass
from typing import Generic, TypeVar

import uvloop
from openrois_media.process import serve_process
from openrois_media.running import prepare_process
from openrois_streaming.aiortc_internals.trial import UnsupportedLibrary
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.network.settings import NetworkSettings

from openrois.adapter.process import run_until_stopped
from openrois.cli.command_line import CommandLine
from openrois.component.component import Component
from openrois.errors import BadParameter
from openrois.metrics.server import MetricsUnavailable
from openrois.observability.logs import set_up_logging
from openrois_robots.adapter.hosting import RunningRobot
from openrois_robots.adapter.options import AdapterSettings, add_adapter_options, read_adapter_settings

__all__ = ["RobotCommand", "run_hosted"]

_S = TypeVar("_S")
_R = TypeVar("_R")


@dataclass(frozen=True, slots=True)
class RobotCommand(Generic[_S]):
    """`openrois robot NAME`.

    Attributes:
        name: of the robot.
        description: for the help.
        engine_id: the default one.
        tables: of the configuration file, as `add_adapter_options` takes it.
        add_options: adds the options that only this robot has.
        read_settings: returns the settings that only this robot has; `ValueError` says what is wrong.
        run: runs the robot while a block does; `BadParameter` and `OSError` say why it cannot.
    """

    name: str
    description: str
    engine_id: str
    tables: str
    add_options: Callable[[argparse.ArgumentParser], None]
    read_settings: Callable[[argparse.Namespace], _S]
    run: Callable[[AdapterSettings, _S], AbstractAsyncContextManager[RunningRobot]]

    def main(self, arguments: Sequence[str]) -> int:
        """Run the command and return its exit status: 0 when stopped, 1 when it could not start, 2 for wrong usage."""
        called = f"openrois robot {self.name}"
        parser = CommandLine(called, description=self.description)
        add_adapter_options(parser, self.engine_id, self.tables)
        self.add_options(parser)
        chosen = parser.parse_args(arguments)
        try:
            settings, own = read_adapter_settings(chosen), self.read_settings(chosen)
        except ValueError as error:
            parser.error(str(error))
        try:
            # Both are read again whenever they are needed; an error now is most likely a mistake.
            settings.credentials.newest()
            for url in settings.gateways:
                settings.credentials.context(url)
        except ValueError as error:
            print(f"{called}: {error}", file=sys.stderr)
            return 1
        set_up_logging(verbose=chosen.verbose, form=chosen.log_format)
        prepare_process()
        try:
            uvloop.run(run_until_stopped(self._serve(settings, own)))
        except (UnsupportedLibrary, BadParameter, MetricsUnavailable, OSError) as error:
            print(f"{called}: {error}", file=sys.stderr)
            return 1
        return 0

    async def _serve(self, settings: AdapterSettings, own: _S) -> None:
        async with self.run(settings, own) as robot:
            await serve_process(
                robot.host,
                settings.gateways,
                settings.credentials,
                robot.collect_figures,
                settings.metrics,
                robot.requirements,
            )


def run_hosted(
    made: Callable[[str, _S, MediaClock], AbstractAsyncContextManager[_R]],
    hosted: Callable[
        [str, _R, MediaClock, NetworkSettings, Sequence[type[Component]]], AbstractAsyncContextManager[RunningRobot]
    ],
) -> Callable[[AdapterSettings, _S], AbstractAsyncContextManager[RunningRobot]]:
    """Return what runs a robot on the clock of this machine: `run` of its command.

    Args:
        made: makes or links the robot, from its engine_id and settings.
        hosted: makes an engine of it, with the settings of its streams, and the components that the user adds.
    """

    @asynccontextmanager
    async def run(settings: AdapterSettings, own: _S) -> AsyncIterator[RunningRobot]:
        clock = SystemClock()
        async with (
            made(settings.engine_id, own, clock) as robot,
            hosted(settings.engine_id, robot, clock, settings.network, settings.components) as running,
        ):
            yield running

    return run
