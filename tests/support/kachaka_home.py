"""A simulated Kachaka and its adapter behind a real gateway."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass

from openrois_robots.kachaka.adapter import Robot, hosted_kachaka
from openrois_robots.kachaka.simulator.servicer import Picture, SimulatorServicer
from openrois_streaming.clock import SystemClock

from openrois.adapter.dialer import serve_parent
from tests.support.deployment import gateway
from tests.support.kachaka import PATIENCE, linked, simulated

__all__ = ["Home", "home"]


@dataclass
class Home:
    """A simulated robot and its adapter behind a real gateway."""

    servicer: SimulatorServicer
    robot: Robot
    url: str


@asynccontextmanager
async def home(picture: Picture | None = None, frame_rate: float = 30.0) -> AsyncIterator[Home]:
    """Run a gateway, and a robot behind it with its streams, as `kachaka`."""
    clock = SystemClock()
    async with (
        gateway() as running,
        simulated(1.0, picture=picture, frame_rate=frame_rate) as (servicer, address),
        linked(address, "kachaka") as robot,
        hosted_kachaka("kachaka", robot, clock) as adapter,
    ):
        url = running.url.replace("http", "ws", 1)
        there = asyncio.Event()
        serving = asyncio.create_task(serve_parent(adapter.host, f"{url}adapter", attached=lambda _: there.set()))
        try:
            async with asyncio.timeout(PATIENCE):
                await there.wait()
            yield Home(servicer, robot, url)
        finally:
            serving.cancel()
            await asyncio.wait({serving})
