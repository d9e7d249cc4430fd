"""A simulated Reachy Mini over its daemon's protocol, and its adapter behind a gateway in memory."""

import asyncio
import json
import time
import uuid
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import pairwise
from typing import Any, Protocol, Self

import aiohttp
from openrois_robots.reachy.adapter import Robot, linked_reachy
from openrois_robots.reachy.daemon.address import Address
from openrois_robots.reachy.options import ReachySettings
from openrois_robots.reachy.postures.posture import Posture, apart, turned_away
from openrois_robots.reachy.simulator.model import SimulatedReachy
from openrois_robots.reachy.simulator.server import SimulatedDaemon, serve_simulator
from openrois_streaming.clock import SystemClock

from openrois.client import Client
from openrois.testing import harness
from tests.support.robots import RobotProcess, until
from tests.support.voice import ScriptedSynthesizer

__all__ = [
    "REACTION",
    "DaemonPlace",
    "DaemonProcess",
    "Linked",
    "LocalDaemon",
    "Watcher",
    "daemon_process",
    "linked",
    "scripted_synthesizer",
    "simulated",
    "staged",
]

ALWAYS = {"system_info", "dialogue"}
"""Components that work without a robot: one says what is wrong, and one keeps what an application said."""
REACTION = "urn:x-rois:def:reaction:OpenRoIS::"
"""What the refs of most reactions begin with."""


@dataclass
class Linked:
    """An adapter's robot that is linked, and an application."""

    daemon: SimulatedDaemon
    robot: Robot
    client: Client
    address: Address

    @property
    def simulation(self) -> SimulatedReachy:
        return self.daemon.robot


@asynccontextmanager
async def simulated(**options: Any) -> AsyncIterator[tuple[SimulatedDaemon, Address]]:
    """Run a simulated robot in this process."""
    daemon = SimulatedDaemon(SimulatedReachy(**options))
    async with serve_simulator(daemon) as port:
        yield daemon, Address("127.0.0.1", port)


@asynccontextmanager
async def linked(address: Address, engine_id: str = "robot", **settings: Any) -> AsyncIterator[Robot]:
    """Link a robot, and wait until it is."""
    async with linked_reachy(engine_id, ReachySettings(address, **settings), SystemClock()) as robot:
        await until(lambda: robot.state.link.is_up)
        yield robot


@asynccontextmanager
async def scripted_synthesizer(_choice: object, _clock: object) -> AsyncIterator[ScriptedSynthesizer]:
    """Stand in for the speech process."""
    yield ScriptedSynthesizer(0.3)


@asynccontextmanager
async def staged(**options: Any) -> AsyncIterator[Linked]:
    """Run a simulated robot and its adapter behind a gateway in memory."""
    async with (
        simulated(**options) as (daemon, address),
        linked(address) as robot,
        harness(*robot.components) as client,
    ):
        yield Linked(daemon, robot, client, address)


class DaemonPlace(Protocol):
    """A daemon in a process of its own, simulated or the vendor's."""

    @property
    def address(self) -> Address:
        """Where it is."""
        ...

    async def kill(self) -> None:
        """Let it die."""
        ...

    async def start_again(self) -> None:
        """Start it at the same address, and wait until it is ready."""
        ...


class Watcher:
    """Another client of a daemon, which sees what the robot does.

    Attributes:
        postures: that the daemon has told, and when each came.
        ended: ids of the tasks whose end it has told, its errors, and when each came.
        on_posture: called with each posture.
    """

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.postures: list[tuple[float, Posture]] = []
        self.ended: list[tuple[str, str | None, float]] = []
        self.on_posture: Callable[[Posture], None] = lambda _posture: None
        self._socket = socket
        self._joints: tuple[float, list[float]] | None = None

    @classmethod
    @asynccontextmanager
    async def watching(cls, address: Address) -> AsyncIterator[Self]:
        """Watch the daemon at an address, from its first posture on."""
        async with aiohttp.ClientSession(address.url("http")) as session, session.ws_connect("/ws/sdk") as socket:
            watcher = cls(socket)
            reading = asyncio.create_task(watcher._read())
            try:
                await until(lambda: watcher.postures)
                yield watcher
            finally:
                reading.cancel()
                await asyncio.wait((reading,))

    @property
    def posture(self) -> Posture:
        """The last one."""
        return self.postures[-1][1]

    async def send(self, **message: object) -> None:
        """Send the daemon a message."""
        await self._socket.send_str(json.dumps(message))

    async def begin_task(self, goal: Posture, duration: float) -> str:
        """Begin a task of the daemon's own, and return its id."""
        task_id = str(uuid.uuid4())
        request = {"head": goal.matrix, "antennas": goal.antennas, "body_yaw": goal.body, "duration": duration}
        now = datetime.now(UTC).isoformat()
        await self.send(type="task", uuid=task_id, timestamp=now, req={**request, "method": "minjerk"})
        return task_id

    async def close(self) -> None:
        """Close the connection."""
        await self._socket.close()

    def largest_step(self, since: int = 0) -> float:
        """Return by how many radians head, body or an antenna turned from one control step to the next at the most."""
        postures = [posture for _, posture in self.postures[since:]]
        return max(
            max(turned_away(one, other), abs(one.right - other.right), abs(one.left - other.left))
            for one, other in pairwise(postures)
        )

    def moves(self, seconds: float = 0.2) -> bool:
        """Tell whether the robot has moved in the last seconds."""
        now = time.monotonic()
        return any(
            at > now - seconds and apart(one, other) > 1e-3 for (_, one), (at, other) in pairwise(self.postures[-50:])
        )

    def stood_at(self, since: float) -> float:
        """Return the time of the last motion after a moment, or that moment."""
        moved = [at for (_, one), (at, other) in pairwise(self.postures) if at > since and apart(one, other) > 1e-3]
        return max([since, *moved])

    async def _read(self) -> None:
        async for message in self._socket:
            told = json.loads(message.data)
            if told["type"] == "joint_positions":
                self._joints = told["head_joint_positions"][0], told["antennas_joint_positions"]
            elif told["type"] == "head_pose" and self._joints is not None:
                posture = Posture.from_matrix(told["head_pose"], *self._joints)
                self.postures.append((time.monotonic(), posture))
                self.on_posture(posture)
            elif told["type"] == "task_progress":
                self.ended.append((told["uuid"], told["error"], time.monotonic()))


class LocalDaemon:
    """A simulated daemon in this process, which can die and return."""

    def __init__(self, **options: Any) -> None:
        self.daemon = SimulatedDaemon(SimulatedReachy(**options))
        self.address = Address("127.0.0.1", 0)
        self._options = options
        self._serving = AsyncExitStack()

    @classmethod
    @asynccontextmanager
    async def running(cls, **options: Any) -> AsyncIterator[Self]:
        """Run it."""
        made = cls(**options)
        await made.start_again()
        try:
            yield made
        finally:
            await made.kill()

    async def kill(self) -> None:
        await self._serving.aclose()

    async def start_again(self) -> None:
        self.daemon = SimulatedDaemon(SimulatedReachy(**self._options))
        serving = serve_simulator(self.daemon, port=self.address.port)
        self.address = Address("127.0.0.1", await self._serving.enter_async_context(serving))


class DaemonProcess(RobotProcess):
    """A simulated daemon in a process of its own."""

    @property
    def address(self) -> Address:
        return Address("127.0.0.1", self.port)


def daemon_process(*options: str) -> AbstractAsyncContextManager[DaemonProcess]:
    """Run a simulated daemon in a process of its own."""
    return DaemonProcess.running("openrois_robots.reachy.simulator", *options)
