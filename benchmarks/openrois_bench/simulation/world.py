"""The bodies behind gateways, the applications before them, and what they do at which time."""

import asyncio
import random
from collections import Counter
from collections.abc import AsyncIterator, Callable, Coroutine, Iterable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

from openrois.aio.tasks import TaskScope
from openrois_bench.simulation.applications import Application
from openrois_bench.simulation.bodies import Body
from openrois_bench.simulation.door import Door
from openrois_bench.simulation.mix import RATES

__all__ = ["Act", "Plan", "World", "at_times", "spread", "world"]


@dataclass(frozen=True, slots=True)
class Plan:
    """What is simulated.

    Attributes:
        bodies: how many, spread over the gateways.
        applications: how many; the bodies share them.
        gateways: how many.
        foreign: share of applications that dial another gateway than the one that owns their body.
        seeing_all: share of applications that have every body of a gateway in their scope.
        hours: virtual hours of the long day at the end.
        rush: seconds in which all applications are at work together.
        visit: seconds for which an application that visits its body in the long day receives events.
        rate: how many times as many events bodies have as usual.
        pace: how many times faster than usual one act begins after the other, where one kind of work is measured.
        seed: of all chance.
    """

    bodies: int = 100
    applications: int = 1000
    gateways: int = 16
    foreign: float = 0.5
    seeing_all: float = 0.01
    hours: float = 12.0
    rush: float = 10.0
    visit: float = 15.0
    rate: float = 1.0
    pace: float = 1.0
    seed: int = 1


@dataclass(slots=True)
class World:
    """What takes part.

    Attributes:
        chance: of the plan's seed.
        counts: what happened, by name.
        tasks: owns what peers do.
    """

    plan: Plan
    tasks: TaskScope
    chance: random.Random
    counts: Counter[str]
    bodies: list[Body] = field(default_factory=list)
    applications: list[Application] = field(default_factory=list)


@asynccontextmanager
async def world(plan: Plan, doors: Sequence[Door], counts: Counter[str]) -> AsyncIterator[World]:
    """Make the bodies behind gateways and the applications before them, which have yet to connect."""
    async with TaskScope() as tasks:
        made = World(plan, tasks, random.Random(plan.seed), counts)
        for number in range(plan.bodies):
            gateway = doors[number % len(doors)]
            made.bodies.append(Body(number, gateway, plan.rate * made.chance.uniform(*RATES), made.counts, made.tasks))
        for number in range(plan.applications):
            body = made.bodies[number % plan.bodies]
            front = body.gateway
            if len(doors) > 1 and made.chance.random() < plan.foreign:
                front = made.chance.choice([each for each in doors if each is not body.gateway])
            sees_all = made.chance.random() < plan.seeing_all
            made.applications.append(
                Application(number, front, body, sees_all=sees_all, counts=made.counts, tasks=made.tasks)
            )
        yield made


Act = Callable[[], Coroutine[Any, Any, None]]
"""Something to be done; made when its turn comes."""


async def at_times(acts: Iterable[tuple[float, Act]]) -> None:
    """Begin each act at its time, and wait until all have ended.

    Args:
        acts: seconds from now, rising, and what begins then.
    """
    loop = asyncio.get_running_loop()
    began = loop.time()
    async with asyncio.TaskGroup() as running:
        for seconds, act in acts:
            await asyncio.sleep(began + seconds - loop.time())
            running.create_task(act())


async def spread(acts: Sequence[Act], seconds: float) -> None:
    """Begin one act after the other, evenly over some seconds, and wait until all have ended."""
    await at_times((seconds * number / len(acts), act) for number, act in enumerate(acts))
