"""A simulated Kachaka over real gRPC, here or in a process of its own, and its adapter behind a gateway in memory."""

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Any

from openrois_robots.kachaka.adapter import Robot, linked_kachaka
from openrois_robots.kachaka.api.address import Address
from openrois_robots.kachaka.options import KachakaSettings
from openrois_robots.kachaka.simulator.house import HOUSE, House, Pose
from openrois_robots.kachaka.simulator.robot import RobotSettings, SimulatedKachaka
from openrois_robots.kachaka.simulator.servicer import Picture, SimulatorServicer, serve_simulator
from openrois_streaming.clock import SystemClock

from openrois.client import Client
from openrois.testing import harness

__all__ = [
    "FAST",
    "HomeProcess",
    "Linked",
    "ended",
    "linked",
    "simulated",
    "simulator_process",
    "staged",
    "until",
]

FAST = 20.0
"""Seconds of the robot in one: what it does takes its time, and tests do not wait for it."""
PATIENCE = 30.0
"""Seconds that anything may take on a busy machine."""


async def until(holds: Callable[[], object], patience: float = PATIENCE) -> None:
    """Wait until something holds that tells of no event."""
    async with asyncio.timeout(patience):
        while not holds():  # noqa: ASYNC110 - it tells of no event
            await asyncio.sleep(0.005)


@asynccontextmanager
async def simulated(
    pace: float = FAST,
    house: House = HOUSE,
    *,
    settings: RobotSettings | None = None,
    at: Pose | None = None,
    picture: Picture | None = None,
    frame_rate: float = 30.0,
    servicer: type[SimulatorServicer] = SimulatorServicer,
) -> AsyncIterator[tuple[SimulatorServicer, Address]]:
    """Run a simulated robot in this process."""
    robot = SimulatedKachaka(settings or RobotSettings(), house)
    if at is not None:
        robot.body.pose, robot.premises.is_docked = at, False
    made = servicer(robot, pace, picture, frame_rate)
    async with serve_simulator(made) as port:
        yield made, Address("127.0.0.1", port)


@dataclass
class Linked:
    """An adapter's robot that is linked, and an application."""

    servicer: SimulatorServicer
    robot: Robot
    client: Client

    @property
    def simulation(self) -> SimulatedKachaka:
        return self.servicer.robot


@asynccontextmanager
async def linked(address: Address, engine_id: str = "robot", **settings: Any) -> AsyncIterator[Robot]:
    """Link a robot, and wait until it is."""
    own = KachakaSettings(address, **settings)
    async with linked_kachaka(engine_id, own, SystemClock()) as robot:
        await until(lambda: robot.state.link.is_up and robot.state.layout.locations)
        yield robot


@asynccontextmanager
async def staged(
    pace: float = FAST,
    *,
    at: Pose | None = None,
    simulation: RobotSettings | None = None,
    picture: Picture | None = None,
    servicer: type[SimulatorServicer] = SimulatorServicer,
    **settings: Any,
) -> AsyncIterator[Linked]:
    """Run a simulated robot and its adapter, without streams, behind a gateway in memory."""
    async with (
        simulated(pace, settings=simulation, at=at, picture=picture, servicer=servicer) as (made, address),
        linked(address, **settings) as robot,
        harness(*robot.components) as client,
    ):
        yield Linked(made, robot, client)


class HomeProcess:
    """A simulator in a process of its own, which can be frozen, killed and started again at its port."""

    def __init__(self, process: asyncio.subprocess.Process, address: Address, options: tuple[str, ...]) -> None:
        self.process = process
        self.address = address
        self._options = options

    def freeze(self) -> None:
        os.kill(self.process.pid, signal.SIGSTOP)

    def thaw(self) -> None:
        os.kill(self.process.pid, signal.SIGCONT)

    async def kill(self) -> None:
        with suppress(ProcessLookupError):
            self.process.kill()
        await self.process.wait()

    async def said(self) -> str:
        """Return what it printed as errors, once it has ended."""
        assert self.process.stderr is not None
        return (await self.process.stderr.read()).decode()

    async def start_again(self) -> None:
        self.process, _ = await _launched(self.address.port, self._options)


async def _launched(port: int, options: tuple[str, ...]) -> tuple[asyncio.subprocess.Process, int]:
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "openrois_robots.kachaka.simulator", "--port", str(port), *options),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    assert process.stdout is not None
    async with asyncio.timeout(PATIENCE):
        ready = await process.stdout.readline()
    assert ready.startswith(b"ready "), ready
    return process, int(ready.rpartition(b":")[2])


@asynccontextmanager
async def simulator_process(*options: str) -> AsyncIterator[HomeProcess]:
    """Run a simulator in a process of its own."""
    process, port = await _launched(0, options)
    home = HomeProcess(process, Address("127.0.0.1", port), options)
    try:
        yield home
    finally:
        await home.kill()


async def ended(work: Awaitable[object]) -> BaseException | None:
    """Return what a work raises; None where it raises nothing."""
    (outcome,) = await asyncio.gather(work, return_exceptions=True)
    return outcome if isinstance(outcome, BaseException) else None
