"""A simulated Kachaka and its adapter behind a real gateway."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass

from openrois_robots.kachaka.adapter import Robot, hosted_kachaka
from openrois_robots.kachaka.simulator.servicer import Picture, SimulatorServicer
from openrois_streaming.clock import SystemClock

from openrois.adapter.dialer import serve_parent
from tests.support.deployment import gateway
from tests.support.kachaka import linked, simulated
from tests.support.robots import PATIENCE

__all__ = ["Home", "home", "housed"]


@dataclass
class Home:
    """A simulated robot and its adapter behind a real gateway."""

    servicer: SimulatorServicer
    robot: Robot
    url: str


@asynccontextmanager
async def home(picture: Picture | None = None, frame_rate: float = 30.0) -> AsyncIterator[Home]:
    """Run a gateway, and a robot behind it with its streams, as `kachaka`."""
    async with (
        simulated(1.0, picture=picture, frame_rate=frame_rate) as (servicer, address),
        housed(linked(address, "kachaka")) as (url, robot),
    ):
        yield Home(servicer, robot, url)


@asynccontextmanager
async def housed(linking: AbstractAsyncContextManager[Robot]) -> AsyncIterator[tuple[str, Robot]]:
    """Run a gateway, and a robot that is linked behind it with its streams; yield the gateway's address too."""
    async with (
        gateway() as running,
        linking as robot,
        hosted_kachaka("kachaka", robot, SystemClock()) as adapter,
    ):
        url = running.url.replace("http", "ws", 1)
        there = asyncio.Event()
        serving = asyncio.create_task(serve_parent(adapter.host, f"{url}adapter", attached=lambda _: there.set()))
        try:
            async with asyncio.timeout(PATIENCE):
                await there.wait()
            yield url, robot
        finally:
            serving.cancel()
            await asyncio.wait({serving})
