"""`openrois robot kachaka`: run the adapter of a Kachaka until a signal stops it."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final

from openrois_streaming.clock import SystemClock

from openrois_robots.adapter.options import AdapterSettings
from openrois_robots.adapter.process import RobotCommand, RunningRobot
from openrois_robots.kachaka.adapter import hosted_kachaka, linked_kachaka
from openrois_robots.kachaka.options import TABLES, KachakaSettings, add_options, read_settings

__all__ = ["COMMAND"]


@asynccontextmanager
async def _run(settings: AdapterSettings, own: KachakaSettings) -> AsyncIterator[RunningRobot]:
    clock = SystemClock()
    async with (
        linked_kachaka(settings.engine_id, own, clock) as robot,
        hosted_kachaka(settings.engine_id, robot, clock, settings.network) as running,
    ):
        yield running


COMMAND: Final = RobotCommand(
    "kachaka", "A Kachaka behind a gateway.", "kachaka", TABLES, add_options, read_settings, _run
)
"""The command of a Kachaka."""
