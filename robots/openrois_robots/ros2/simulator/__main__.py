"""`python -m openrois_robots.ros2.simulator`: run a simulated robot that speaks ROS 2, until Ctrl-C ends it."""

import argparse
import asyncio
import sys
import time

from openrois_streaming.clock import SystemClock

from openrois.adapter.process import run_until_stopped
from openrois_robots.ros2.interfaces.store import DEFAULT_DISTRIBUTION, DISTRIBUTIONS
from openrois_robots.ros2.simulator.node import SimulatedNode, SimulatorSettings

__all__ = ["main"]


def main() -> int:
    """Run the simulator and return its exit status: 0 when stopped, 1 when it could not start."""
    parser = argparse.ArgumentParser("python -m openrois_robots.ros2.simulator", description=__doc__)
    parser.add_argument("--domain", type=int, default=0, help="of DDS, as ROS_DOMAIN_ID (%(default)s)")
    parser.add_argument("--namespace", default="/", help="of all its names (%(default)s)")
    parser.add_argument(
        "--distribution", choices=DISTRIBUTIONS, default=DEFAULT_DISTRIBUTION, help="of ROS (%(default)s)"
    )
    parser.add_argument("--battery", type=float, default=80.0, metavar="PERCENT", help="at first (%(default)s)")
    parser.add_argument("--best-effort", action="store_true", help="publish its sensors best-effort")
    parser.add_argument("--reject", action="store_true", help="reject all goals")
    parser.add_argument(
        "--tell-stops",
        action="store_true",
        help="print `stopped` and the seconds of the system's monotonic clock whenever it is told to stop",
    )
    chosen = parser.parse_args()
    settings = SimulatorSettings(
        chosen.domain,
        chosen.namespace,
        chosen.distribution,
        chosen.battery,
        "best_effort" if chosen.best_effort else "reliable",
        chosen.reject,
    )
    node = SimulatedNode(settings, SystemClock())
    if chosen.tell_stops:
        node.stopped.add(lambda: print(f"stopped {time.monotonic():.6f}", flush=True))
    try:
        asyncio.run(run_until_stopped(node.run(lambda: print("ready", flush=True))))
    except OSError as error:
        print(f"the simulated robot cannot run: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
