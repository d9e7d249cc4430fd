"""`python -m openrois_robots.reachy.simulator`: a simulated daemon until a signal stops it."""

import argparse
import asyncio
import signal
import sys
from collections.abc import Sequence
from math import radians

from openrois_robots.reachy.postures.posture import ASLEEP, NEUTRAL
from openrois_robots.reachy.simulator.model import SimulatedReachy
from openrois_robots.reachy.simulator.server import SimulatedDaemon, serve_simulator

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the simulator, and return its exit status: 0 when stopped, 1 when its port is taken."""
    parser = argparse.ArgumentParser(
        "python -m openrois_robots.reachy.simulator",
        description="The daemon of a simulated Reachy Mini: it prints `ready HOST:PORT`.",
    )
    parser.add_argument("--host", default="127.0.0.1", help="address to listen at (%(default)s)")
    parser.add_argument("--port", type=int, default=8000, help="0 for any that is free (%(default)s)")
    parser.add_argument("--media", action="store_true", help="take sounds as heard; without it as with --no-media")
    parser.add_argument("--asleep", action="store_true", help="begin asleep, with the motors off")
    parser.add_argument("--held", action="store_true", help="have something hold the head: it follows no target")
    parser.add_argument(
        "--sound-from", type=float, metavar="DEGREES", help="hear a voice there: 0 is left, 180 right (without it none)"
    )
    chosen = parser.parse_args(arguments)
    robot = SimulatedReachy(
        posture=ASLEEP if chosen.asleep else NEUTRAL,
        motors="disabled" if chosen.asleep else "enabled",
        has_media=chosen.media,
        is_held=chosen.held,
        sound_from=None if chosen.sound_from is None else radians(chosen.sound_from),
    )
    try:
        asyncio.run(_serve(SimulatedDaemon(robot), chosen.host, chosen.port))
    except OSError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


async def _serve(daemon: SimulatedDaemon, host: str, port: int) -> None:
    stopped = asyncio.Event()
    for name in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(name, stopped.set)
    async with serve_simulator(daemon, host, port) as bound:
        print(f"ready {host}:{bound}", flush=True)
        await stopped.wait()


if __name__ == "__main__":
    sys.exit(main())
