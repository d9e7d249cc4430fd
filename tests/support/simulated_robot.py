"""A simulated robot on a clock that is moved by hand."""

import asyncio
from collections.abc import AsyncIterator, Awaitable
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import Any
from unittest.mock import patch

from openrois_body.messages import Completed, Event, Place
from openrois_body.motion import wayfinding
from openrois_robots.simulated.adapter import Robot, simulated_robot
from openrois_robots.simulated.battery import BatterySettings
from openrois_robots.simulated.simulation import Simulation, SimulationSettings
from openrois_robots.simulated.world.plan import APARTMENT, Plan
from openrois_streaming.clock import MediaClock

from openrois.client import Client
from openrois.testing import harness
from tests.support.streaming import VirtualClock, settle
from tests.support.voice import ScriptedSynthesizer

__all__ = ["Rooms", "Stage", "at", "scripted_synthesizer", "staged"]

TURN = 0.1
"""Seconds of the clock at a time."""


def at(x: float, y: float, th: float = 0.0, plan: Plan = APARTMENT) -> Plan:
    """Return the plan with the robot somewhere else at first."""
    return replace(plan, start=Place(x, y, th))


class Rooms:
    """The simulation alone, and what it has reported."""

    def __init__(self, plan: Plan = APARTMENT, *, visitor: bool = False, **battery: float) -> None:
        self.clock = VirtualClock()
        self.told: list[Event] = []
        settings = SimulationSettings(battery=BatterySettings(**battery), visitor=visitor)
        self.simulation = Simulation(plan, settings, self.clock, self.told.append)
        self.simulation.begin()

    @property
    def place(self) -> Place:
        return self.simulation.place

    def run(self, seconds: float, turn: float = TURN) -> None:
        """Let time pass."""
        for _ in range(round(seconds / turn)):
            self.clock.jump(turn)
            self.simulation.advance()

    def outcome(self, seconds: float = 60.0) -> Completed:
        """Let time pass until a walk has ended."""
        for _ in range(round(seconds / TURN)):
            self.run(TURN)
            ends = [each for each in self.told if isinstance(each, Completed)]
            if ends:
                return ends[-1]
        raise TimeoutError(f"no walk has ended within {seconds} s")


class Stage:
    """The robot with its components behind a gateway in memory, and an application.

    Attributes:
        robot: that is tried.
        client: the application.
        clock: of the robot.
    """

    def __init__(self, robot: Robot, client: Client, clock: VirtualClock) -> None:
        self.robot = robot
        self.client = client
        self.clock = clock

    @property
    def place(self) -> Place:
        return self.robot.simulation.place

    async def run(self, seconds: float) -> None:
        """Let time pass."""
        for _ in range(round(seconds / TURN)):
            await self.clock.advance(TURN)
            await settle()

    async def until(self, work: Awaitable[Any], seconds: float = 90.0) -> Any:
        """Let time pass until something is done, and return what it returned.

        Raises:
            TimeoutError: it is not done within so many seconds of the robot's clock.
        """
        done = asyncio.ensure_future(work)
        for _ in range(round(seconds / TURN)):
            if done.done():
                return done.result()
            await self.run(TURN)
        done.cancel()
        raise TimeoutError(f"not done within {seconds} s, with the robot at {self.place}")


@asynccontextmanager
async def scripted_synthesizer(_choice: object, _clock: MediaClock) -> AsyncIterator[ScriptedSynthesizer]:
    """Stand in for the speech process of a robot."""
    yield ScriptedSynthesizer()


@asynccontextmanager
async def staged(plan: Plan = APARTMENT, *, visitor: bool = False, **battery: float) -> AsyncIterator[Stage]:
    """Run a robot without streams for as long as the block does; without a thread for its ways, or a speech process."""
    clock = VirtualClock()
    settings = SimulationSettings(battery=BatterySettings(**battery), visitor=visitor)
    speechless = patch("openrois_body.speech_options.VoiceChoice.make", scripted_synthesizer)
    with patch.object(wayfinding, "_SMALL", 1000), speechless:
        async with simulated_robot("robot", settings, clock, plan) as robot, harness(*robot.components) as client:
            yield Stage(robot, client, clock)
