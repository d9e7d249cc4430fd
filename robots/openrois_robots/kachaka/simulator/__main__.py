"""`python -m openrois_robots.kachaka.simulator`: a simulated Kachaka until a signal stops it."""

import argparse
import asyncio
import signal
import sys
import time
from collections.abc import Sequence

from openrois_robots.kachaka.simulator.robot import RobotSettings, SimulatedKachaka
from openrois_robots.kachaka.simulator.servicer import SimulatorServicer, serve_simulator

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the simulator, and return its exit status: 0 when stopped, 1 when its port is taken."""
    parser = argparse.ArgumentParser(
        "python -m openrois_robots.kachaka.simulator",
        description="A simulated Kachaka on the vendor's gRPC service: it prints `ready HOST:PORT`.",
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen at (%(default)s)")
    parser.add_argument("--port", type=int, default=26400, help="0 for any that is free (%(default)s)")
    parser.add_argument("--battery", type=float, default=80.0, metavar="PERCENT", help="at first (%(default)g)")
    parser.add_argument("--pace", type=float, default=1.0, help="seconds of the robot in one (%(default)g)")
    parser.add_argument(
        "--speaks-while-driving", action="store_true", help="speak beside a command that runs, not after it"
    )
    parser.add_argument(
        "--tell-stops",
        action="store_true",
        help="print `stopped` and the seconds of the system's monotonic clock whenever it is told to stop",
    )
    chosen = parser.parse_args(arguments)
    settings = RobotSettings(battery=chosen.battery, speaks_while_driving=chosen.speaks_while_driving)
    try:
        asyncio.run(_serve(settings, chosen))
    except OSError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


async def _serve(settings: RobotSettings, chosen: argparse.Namespace) -> None:
    stopped = asyncio.Event()
    for name in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(name, stopped.set)
    robot = SimulatedKachaka(settings)
    if chosen.tell_stops:
        robot.stopped.add(lambda: print(f"stopped {time.monotonic():.6f}", flush=True))
    async with serve_simulator(SimulatorServicer(robot, chosen.pace), chosen.host, chosen.port) as bound:
        print(f"ready {chosen.host}:{bound}", flush=True)
        await stopped.wait()


if __name__ == "__main__":
    sys.exit(main())
