"""Detection of a lost adapter by a gateway: killed, stopped, or behind a half-open connection.

    python -m openrois_bench.faults.detection [ROUNDS]

From the fault to the `completed` of the command that ran, at an application; with the pings of every gateway.
"""

import argparse
import asyncio
import os
import random
import signal
import sys
import time
from collections.abc import Awaitable, Callable
from contextlib import AsyncExitStack, suppress
from functools import partial

from openrois.adapter import Component, command, run, serve
from openrois.client import Client
from openrois.errors import ComponentFailed
from openrois.gateway.server import run_gateway
from openrois.gateway.settings import GatewaySettings
from openrois.testing import FaultRelay

ROBOTS = 8
"""At a time, so that their faults fall on different moments between two pings."""


class Patient(Component):
    """Component whose command does not end."""

    @command
    async def wait(self) -> None:
        """Wait for ever."""
        await asyncio.Event().wait()


async def took(client: Client, engine_id: str, fault: Callable[[], None]) -> float:
    """Return the seconds from a fault to the end of the command that ran."""
    while f"{engine_id}/patient" not in await client.search():  # noqa: ASYNC110 - it is asked until it is there
        await asyncio.sleep(0.02)
    waiting = await client.execute(client.component(f"{engine_id}/patient").command("wait"))
    await asyncio.sleep(random.random() * 2)
    began = time.monotonic()
    fault()
    with suppress(ComponentFailed):
        await waiting
    return time.monotonic() - began


async def killed_or_stopped(number: int) -> list[float]:
    """Send a signal to robots that are processes."""
    async with (
        run_gateway(GatewaySettings(port=0)) as gateway,
        Client(gateway.url) as client,
        AsyncExitStack() as stack,
    ):
        ids = [f"robot{index}" for index in range(ROBOTS)]
        faults = []
        for engine_id in ids:
            program = (sys.executable, "-m", "openrois_bench.faults.detection", "--robot", gateway.url, engine_id)
            robot = await asyncio.create_subprocess_exec(*program, stderr=asyncio.subprocess.DEVNULL)
            stack.push_async_callback(_kill, robot)
            faults.append(partial(robot.send_signal, number))
        return await asyncio.gather(*(took(client, *each) for each in zip(ids, faults, strict=True)))


async def _kill(robot: asyncio.subprocess.Process) -> None:
    if robot.returncode is None:
        robot.kill()
    await robot.wait()


async def half_open() -> list[float]:
    """Pull the cable of robots of this process."""
    async with (
        run_gateway(GatewaySettings(port=0)) as gateway,
        Client(gateway.url) as client,
        AsyncExitStack() as stack,
    ):
        pairs = []
        for index in range(ROBOTS):
            relay = await stack.enter_async_context(FaultRelay(gateway.url))
            await stack.enter_async_context(serve(Patient("patient"), engine_id=f"robot{index}", gateway=relay.url))
            pairs.append((f"robot{index}", relay))
        times = await asyncio.gather(*(took(client, engine_id, relay.half_open) for engine_id, relay in pairs))
        for _, relay in pairs:
            relay.cut(refuse=True)
        return times


async def measure(rounds: int) -> None:
    """Measure and print."""
    measures: dict[str, Callable[[], Awaitable[list[float]]]] = {
        "killed": partial(killed_or_stopped, signal.SIGKILL),
        "stopped": partial(killed_or_stopped, signal.SIGSTOP),
        "half open": half_open,
    }
    for name, measure in measures.items():
        times = sorted([each for _ in range(rounds) for each in await measure()])
        load = ", ".join(f"{each:.1f}" for each in os.getloadavg())
        middle, last = times[len(times) // 2], times[-1]
        print(f"{name}: {len(times)} times, median {middle:.3f} s, longest {last:.3f} s (load {load})", flush=True)


def main() -> None:
    """Measure, or be a robot."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.faults.detection", description=__doc__)
    parser.add_argument("rounds", type=int, nargs="?", default=3, help="of each fault (%(default)s)")
    parser.add_argument("--robot", nargs=2, metavar=("GATEWAY", "ENGINE"), help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.robot:
        gateway, engine_id = chosen.robot
        run(Patient("patient"), gateway=gateway, engine_id=engine_id)
    else:
        asyncio.run(measure(chosen.rounds))


if __name__ == "__main__":
    main()
