"""Recovery after a gateway's restart under a crowd: until its adapters and applications are connected again.

    python -m openrois_bench.faults.restart [--clients 1000] [--robots 8] [--rounds 3] [--kill] [--journal]

The gateway, the adapters and each half of the applications are processes of their own. Times count from the moment at
which the new gateway says that it listens.
"""

import argparse
import asyncio
import os
import signal
import sys
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import uvloop

from openrois.adapter import Component, command, serve
from openrois.client import Client, ConnectionState
from openrois_bench.measuring.conditions import conditions, load

CROWDS: Final = 2
"""Processes with applications."""

LOOK: Final = 0.02
"""Seconds between two looks at how many are connected."""

PATIENCE: Final = 120.0


class Arm(Component, authority="OpenRoIS", function="actuation"):
    """Component to be found again."""

    @command
    async def turn(self) -> None:
        """Turn."""


async def robots(url: str, count: int) -> None:
    """Serve engines with a component each, for ever."""
    async with AsyncExitStack() as stack:
        for number in range(count):
            await stack.enter_async_context(serve(Arm("arm"), engine_id=f"robot{number}", gateway=url))
        print("dialling", flush=True)
        await asyncio.Event().wait()


async def crowd(url: str, count: int) -> None:
    """Run applications that stay, and print when all are gone and when all are back, with the times of each."""
    async with AsyncExitStack() as stack:
        clients = [Client(url) for _ in range(count)]
        for first in range(0, count, 50):
            await asyncio.gather(*(stack.enter_async_context(each) for each in clients[first : first + 50]))
        print("there", flush=True)
        while True:
            left: set[Client] = set()
            back: dict[Client, float] = {}
            while len(back) < count:
                await asyncio.sleep(LOOK)
                for each in clients:
                    if each.state is not ConnectionState.CONNECTED:
                        left.add(each)
                    elif each in left and each not in back:
                        back[each] = time.time()
            print(" ".join(f"{at:.3f}" for at in sorted(back.values())), flush=True)


@dataclass(frozen=True, slots=True)
class Child:
    """A process of ours that says something by the line."""

    process: asyncio.subprocess.Process

    async def says(self) -> str:
        """Return its next line."""
        assert self.process.stdout is not None
        async with asyncio.timeout(PATIENCE):
            return (await self.process.stdout.readline()).decode().strip()


@asynccontextmanager
async def child(*arguments: str, log: Path) -> AsyncIterator[Child]:
    """Run `python ARGUMENTS` while the block runs."""
    with log.open("w") as errors:
        process = await asyncio.create_subprocess_exec(
            sys.executable, *arguments, stdout=asyncio.subprocess.PIPE, stderr=errors, limit=1 << 20
        )
    try:
        yield Child(process)
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()


def attached(log: Path) -> list[float]:
    """Return when each engine was attached, epoch seconds, as the gateway's log says."""
    lines = [line for line in log.read_text().splitlines() if ": attached robot" in line]
    return sorted(datetime.fromisoformat(line.split()[0]).timestamp() for line in lines)


async def one_round(chosen: argparse.Namespace, folder: Path, port: int) -> tuple[float, list[float], list[float]]:
    """Restart a gateway once; return how long it was gone, and after how long each was back: adapters, applications."""
    journal = ("--journal", str(folder / "journal")) if chosen.journal else ()
    gateway = ("-m", "openrois.cli", "gateway", "--port", str(port), "--per-address", "8192", *journal)
    url = f"http://127.0.0.1:{port}/"
    me = ("-m", "openrois_bench.faults.restart", "--url", url)
    share = str(chosen.clients // CROWDS)
    async with AsyncExitStack() as stack:
        async with child(*gateway, log=folder / "first") as first:
            await first.says()
            arms = await stack.enter_async_context(child(*me, "--be-robots", str(chosen.robots), log=folder / "robots"))
            await arms.says()
            crowds = [
                await stack.enter_async_context(child(*me, "--be-clients", share, log=folder / f"crowd{number}"))
                for number in range(CROWDS)
            ]
            for each in crowds:
                await each.says()
            while len(attached(folder / "first")) < chosen.robots:  # noqa: ASYNC110 - it is read until it is there
                await asyncio.sleep(0.1)
            first.process.send_signal(signal.SIGKILL if chosen.kill else signal.SIGTERM)
            await first.process.wait()
        ended = time.time()
        second = await stack.enter_async_context(child(*gateway, log=folder / "second"))
        await second.says()
        listening = time.time()
        back = [float(at) - listening for each in crowds for at in (await each.says()).split()]
        robots_back = [at - listening for at in attached(folder / "second")]
        if len(robots_back) < chosen.robots:
            raise SystemExit(f"only {len(robots_back)} adapters are back")
        return listening - ended, robots_back, sorted(back)


async def measure(chosen: argparse.Namespace) -> None:
    """Measure and print."""
    before = load()
    for number in range(chosen.rounds):
        with TemporaryDirectory() as folder:
            gone, arms, apps = await one_round(chosen, Path(folder), chosen.port)
        earlier = sum(at < arms[-1] for at in apps)
        print(
            f"round {number + 1}: gone for {gone:.1f} s; adapters back after {arms[0]:.2f} to {arms[-1]:.2f} s; "
            f"applications after {apps[0]:.2f} to {apps[-1]:.2f} s, half of them after {apps[len(apps) // 2]:.2f} s; "
            f"{earlier} of them before the last adapter (load {os.getloadavg()[0]:.1f})",
            flush=True,
        )
    print(conditions(before))


def main() -> None:
    """Be what the arguments say."""
    parser = argparse.ArgumentParser(prog="python -m openrois_bench.faults.restart", description=__doc__)
    parser.add_argument("--clients", type=int, default=1000)
    parser.add_argument("--robots", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--port", type=int, default=18771)
    parser.add_argument("--kill", action="store_true", help="SIGKILL, not SIGTERM: without a time to reconnect")
    parser.add_argument("--journal", action="store_true", help="the gateway remembers which adapters were there")
    parser.add_argument("--url", help=argparse.SUPPRESS)
    parser.add_argument("--be-robots", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--be-clients", type=int, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.be_robots:
        uvloop.run(robots(chosen.url, chosen.be_robots))
    elif chosen.be_clients:
        uvloop.run(crowd(chosen.url, chosen.be_clients))
    else:
        asyncio.run(measure(chosen))


if __name__ == "__main__":
    main()
