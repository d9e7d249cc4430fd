"""A simulated Kachaka over real gRPC, here or in a process of its own, and its adapter behind a gateway in memory."""

from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
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
from tests.support.robots import RobotProcess, until

__all__ = ["FAST", "HomeProcess", "Linked", "linked", "simulated", "simulator_process", "staged"]

FAST = 20.0
"""Seconds of the robot in one: what it does takes its time, and tests do not wait for it."""


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


class HomeProcess(RobotProcess):
    """A simulator in a process of its own."""

    @property
    def address(self) -> Address:
        return Address("127.0.0.1", self.port)


def simulator_process(*options: str) -> AbstractAsyncContextManager[HomeProcess]:
    """Run a simulator in a process of its own."""
    return HomeProcess.running("openrois_robots.kachaka.simulator", *options)
