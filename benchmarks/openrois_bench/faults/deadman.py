"""Reaction of the dead man's switch: from a fault to the call of the component's `stop`.

`python -m openrois_bench.faults.deadman`, in the repository; `--runs 100` unless it is said otherwise. A gateway, an
adapter and an application in one process talk through sockets, the faulty connection through a relay. The motion has
run for a while, another one each time, when the fault comes.
"""

import argparse
import asyncio
import json
import random
import time
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass

from openrois.adapter import Component, command
from openrois.adapter.running import serve
from openrois.client import Client
from openrois.gateway.server import Gateway, run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.testing.relay import FaultRelay
from openrois_bench.measuring.conditions import load

REF = "robot/rover"
PATIENCE = 20.0
FAULTS = (
    "the adapter's connection is cut",
    "the adapter's connection is half open",
    "the operator's connection is cut",
)


class Rover(Component, authority="Bench", function="actuation"):
    """Drives, and notes when it is told to stop."""

    dead_man = 0.5

    def __init__(self) -> None:
        super().__init__("rover")
        self.driving = asyncio.Event()
        self.stopped = asyncio.Event()
        self.stopped_at = 0.0

    @command
    async def start(self) -> None:
        """Drive until it is stopped."""
        self.stopped.clear()
        self.driving.set()
        await asyncio.Event().wait()

    @command
    async def stop(self) -> None:
        """Stand still."""
        if self.driving.is_set() and not self.stopped.is_set():
            self.stopped_at = time.perf_counter()
        self.driving.clear()
        self.stopped.set()


@dataclass
class Scene:
    """Driving component, and the two connections that may fail."""

    rover: Rover
    operator: FaultRelay
    robot: FaultRelay

    def faults(self) -> dict[str, Callable[[], None]]:
        """Return what may happen, by name."""
        return dict(zip(FAULTS, (self.robot.cut, self.robot.half_open, self.operator.cut), strict=True))


@asynccontextmanager
async def _scene(gateway: Gateway) -> AsyncIterator[Scene]:
    rover = Rover()
    async with (
        FaultRelay(gateway.url) as operator,
        FaultRelay(f"{gateway.url}adapter") as robot,
        serve(rover, engine_id="robot", gateway=robot.url),
    ):
        yield Scene(rover, operator, robot)


async def fault(name: str, chance: random.Random) -> float:
    """Let one fault happen while something drives; return the milliseconds until it is told to stop."""
    async with (
        asyncio.timeout(PATIENCE),
        run_gateway(GatewaySettings(port=0)) as gateway,
        _scene(gateway) as scene,
        Client(scene.operator.url) as client,
    ):
        rover = await client.find(Rover.component_type, within=PATIENCE)
        await rover.bind()
        await rover.command("start").execute()
        await scene.rover.driving.wait()
        await asyncio.sleep(chance.uniform(0.1, 0.5))
        scene.faults()[name]()
        began = time.perf_counter()
        await scene.rover.stopped.wait()
        return (scene.rover.stopped_at - began) * 1000


async def _measure(runs: int) -> None:
    chance = random.Random(0)
    before = load()
    found = {name: sorted([await fault(name, chance) for _ in range(runs)]) for name in FAULTS}
    told = {
        name: {"p50_ms": round(times[len(times) // 2], 1), "max_ms": round(times[-1], 1)}
        for name, times in found.items()
    }
    print(json.dumps({"runs": runs, "stopped": told, "load_before": before, "load_after": load()}, indent=1))


def main() -> None:
    """Measure, and print what was measured."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=100, help="of each fault (%(default)s)")
    asyncio.run(_measure(parser.parse_args().runs))


if __name__ == "__main__":
    main()
