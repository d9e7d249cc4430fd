"""Stopping of robots: from what ends a motion to the call by which the robot itself is told to stop.

`python -m openrois_bench.faults.robots`, in the repository; `--runs 20` unless it is said otherwise. A gateway, the
adapter and a simulated robot are processes of their own, and each robot drives when it is stopped, or its operator or
its gateway is gone. The robot tells when its own stop was called: `CancelCommand` of a Kachaka; of a robot that speaks
ROS 2 a goal that is cancelled, or a velocity of zero.
"""

import argparse
import asyncio
import os
import random
import signal
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager, suppress
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from tempfile import TemporaryDirectory
from types import MappingProxyType
from typing import Any, Final
from urllib.parse import urlsplit

from openrois_body.processes.child import Output, child_process
from openrois_streaming.clock import SystemClock

from openrois.client import Client
from openrois.errors import RoISError
from openrois.testing import FaultRelay
from openrois_bench.errors import BenchFailed, within
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.measuring.figures import Percentiles
from openrois_bench.measuring.result import write_result
from openrois_bench.measuring.table import table
from openrois_bench.processes.child import Child, child

__all__ = ["FAULTS", "GOAL", "ROBOTS", "Motion", "Stopped", "measured", "stage"]

GOAL: Final = 500.0
"""Milliseconds after which a robot has to have been told to stop."""
FAULTS: Final = ("stop", "STOP for all", "operator cut off", "gateway frozen")
"""What ends a motion."""

_PATIENCE: Final = 30.0
_STOPPED: Final = "stopped "
_LOOPBACK: Final = (
    "<CycloneDDS><Domain>"
    '<General><Interfaces><NetworkInterface name="lo"/></Interfaces><AllowMulticast>false</AllowMulticast></General>'
    '<Discovery><ParticipantIndex>auto</ParticipantIndex><Peers><Peer Address="localhost"/></Peers></Discovery>'
    "</Domain></CycloneDDS>"
)
_DOMAIN: Final = "97"
_MAPPING: Final = """
[odometry]
topic = "odom"
[pose]
topic = "amcl_pose"
[velocity]
topic = "cmd_vel"
[navigation]
action = "navigate_to_pose"
"""


@dataclass(frozen=True, slots=True)
class Motion:
    """A motion of a robot.

    Attributes:
        component: name of the component.
        parameters: of its `start`, which take turns: none of them is reached.
    """

    component: str
    parameters: tuple[Mapping[str, Any], ...]


ROBOTS: Final[Mapping[str, tuple[Motion, ...]]] = MappingProxyType(
    {
        "kachaka": (
            Motion("navigation", ({"target_positions": ["kitchen"]}, {"target_positions": ["entrance"]})),
            Motion("move", ({"line": [900, 0]}, {"line": [-900, 0]})),
        ),
        "ros2": (
            Motion("navigation", ({"target_positions": ["4.5,0"]}, {"target_positions": ["-4.5,0"]})),
            Motion("move", ({"line": [3000, 0]}, {"line": [-3000, 0]})),
        ),
    }
)


@dataclass(frozen=True, slots=True)
class Stopped:
    """How soon a robot was told to stop: milliseconds."""

    robot: str
    component: str
    fault: str
    times: Percentiles
    longest: float


@dataclass(slots=True)
class Stage:
    """A robot behind a gateway.

    Attributes:
        url: of the gateway.
        gateway: its process.
        engine_id: of the robot.
        stops: the times at which the robot was told to stop, in seconds of the monotonic clock.
    """

    url: str
    gateway: Child
    engine_id: str
    stops: "asyncio.Queue[float]"

    async def stopped_after(self, began: float) -> float:
        """Return the milliseconds from a moment to the next stop of the robot."""
        async with within(_PATIENCE, "the stop of the robot"):
            while (at := await self.stops.get()) < began:
                pass
        return (at - began) * 1000

    def forget_stops(self) -> None:
        """Forget the stops that were told."""
        while not self.stops.empty():
            self.stops.get_nowait()


@asynccontextmanager
async def stage(name: str) -> AsyncIterator[Stage]:
    """Run a gateway, a simulated robot and its adapter, each as a process, until all works.

    Args:
        name: of the robot, one of `ROBOTS`.

    Raises:
        BenchFailed: one of them does not start.
    """
    stops: asyncio.Queue[float] = asyncio.Queue()
    ready: asyncio.Future[str] = asyncio.get_running_loop().create_future()

    def heard(line: str) -> None:
        if line.startswith("ready") and not ready.done():
            ready.set_result(line.removeprefix("ready").strip())
        elif line.startswith(_STOPPED):
            stops.put_nowait(float(line.removeprefix(_STOPPED)))

    is_ros = name == "ros2"
    environment = {"CYCLONEDDS_URI": _LOOPBACK, "ROS_DOMAIN_ID": _DOMAIN} if is_ros else {}
    where = ("--domain", _DOMAIN) if is_ros else ("--port", "0")
    simulator = (f"openrois_robots.{name}.simulator", *where, "--tell-stops")
    async with AsyncExitStack() as stack:
        output = Output("robot", SystemClock(), heard)
        await stack.enter_async_context(child_process(*simulator, output=output, environment=environment))
        async with within(_PATIENCE, "the start of the robot"):
            address = await ready
        gateway = await stack.enter_async_context(child("-m", "openrois.cli", "gateway", "--port", "0"))
        url = f"ws://{urlsplit(gateway.said.removeprefix('listening ').strip()).netloc}/"
        mapping = stack.enter_context(_mapping_file())
        own = ("--config", mapping) if is_ros else ("--robot", address)
        command = ("-m", "openrois.cli", "robot", name, "--engine-id", name, "--gateway", f"{url}adapter", *own)
        await stack.enter_async_context(child(*command, environment=environment))
        made = Stage(url, gateway, name, stops)
        await _until_ready(made)
        yield made


@contextmanager
def _mapping_file() -> Iterator[str]:
    with TemporaryDirectory() as folder:
        file = Path(folder, "robot.toml")
        file.write_text(_MAPPING)
        yield str(file)


async def measured(robot: Stage, motion: Motion, fault: str, runs: int, chance: random.Random) -> Stopped:
    """Let one fault happen again and again while the robot drives; raises `BenchFailed` where it does not stop."""
    parameters = cycle(motion.parameters)
    times = []
    for _ in range(runs):
        async with within(_PATIENCE, f"a motion of {robot.engine_id}"):
            times.append(await _tried(robot, motion.component, next(parameters), fault, chance))
    return Stopped(robot.engine_id, motion.component, fault, Percentiles.of(times), round(max(times), 1))


async def _tried(
    robot: Stage, component: str, parameters: Mapping[str, Any], fault: str, chance: random.Random
) -> float:
    async with FaultRelay(robot.url) as relay, AsyncExitStack() as stack:
        other = await stack.enter_async_context(Client(robot.url))
        operator = await stack.enter_async_context(Client(relay.url))
        moving = operator.component(f"{robot.engine_id}/{component}")
        await moving.bind()
        await operator.run(moving.set_parameter(**parameters))
        motion = await moving.command("start").execute()
        await asyncio.sleep(chance.uniform(0.4, 0.7))
        if motion.done:
            raise BenchFailed(f"{component} of {robot.engine_id} has ended by itself: {await _end(motion)}")
        robot.forget_stops()
        faults: Mapping[str, Callable[[], Awaitable[object]]] = {
            "stop": lambda: operator.run(moving.command("stop")),
            "STOP for all": other.control.stop_all,
            "operator cut off": lambda: _cut(relay),
            "gateway frozen": lambda: _frozen(robot),
        }
        began = time.monotonic()
        happening = asyncio.ensure_future(faults[fault]())
        try:
            took = await robot.stopped_after(began)
        finally:
            os.kill(robot.gateway.pid, signal.SIGCONT)
            relay.mend()
        await _end(happening)
        await _end(motion)
    await _until_ready(robot)
    return took


async def _cut(relay: FaultRelay) -> None:
    relay.cut(refuse=True)


async def _frozen(robot: Stage) -> None:
    os.kill(robot.gateway.pid, signal.SIGSTOP)


async def _end(work: Awaitable[object]) -> str:
    """Wait until something has ended, in whichever way; return why it failed."""
    with suppress(TimeoutError):
        async with asyncio.timeout(_PATIENCE):
            try:
                await work
            except (RoISError, OSError) as error:
                return str(error)
    return ""


async def _until_ready(robot: Stage) -> None:
    """Wait until every component that drives is ready: it is asked, as it is for every adapter."""
    async with within(_PATIENCE, f"{robot.engine_id}, ready"), Client(robot.url) as client:
        for motion in ROBOTS[robot.engine_id]:
            component = client.component(f"{robot.engine_id}/{motion.component}")
            while True:
                with suppress(RoISError):
                    if (await component.query("component_status"))["status"] == "READY":
                        break
                await asyncio.sleep(0.05)


async def _measure_all(runs: int, names: tuple[str, ...], file: Path | None) -> bool:
    """Measure and print; return whether all stops came in time."""
    chance, before, found = random.Random(0), load(), list[Stopped]()
    for name in names:
        async with stage(name) as robot:
            for motion in ROBOTS[name]:
                found += [await measured(robot, motion, fault, runs, chance) for fault in FAULTS]
    machine = conditions(before)
    rows = [
        (each.robot, each.component, each.fault, str(runs), f"{each.times.p50:.0f}", f"{each.longest:.0f}")
        for each in found
    ]
    print(machine)
    print(table(("robot", "moves by", "ended by", "tries", "p50 ms", "longest ms"), rows))
    late = [each for each in found if each.longest > GOAL]
    for each in late:
        print(f"{each.robot}, {each.component}, {each.fault}: {each.longest:.0f} ms, more than {GOAL:.0f} ms")
    told = [
        {"robot": each.robot, "component": each.component, "fault": each.fault, **each.times.model_dump()}
        | {"longest": each.longest}
        for each in found
    ]
    write_result(file, "openrois_bench.faults.robots", machine, stopped_ms=told)
    return not late


def main() -> int:
    """Measure, print what was measured, and return the exit status: 1 where a stop came too late."""
    parser = argparse.ArgumentParser("python -m openrois_bench.faults.robots", description=__doc__)
    parser.add_argument("--runs", type=int, default=20, help="of each fault with each motion (%(default)s)")
    parser.add_argument("--robot", choices=tuple(ROBOTS), action="append", help="this one alone")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    chosen = parser.parse_args()
    names = tuple(chosen.robot or ROBOTS)
    return 0 if asyncio.run(_measure_all(chosen.runs, names, chosen.json)) else 1


if __name__ == "__main__":
    raise SystemExit(main())
