"""Many gateways, bodies and applications in virtual time.

`python -m openrois_bench.simulation` runs the gateway's own code, a JSON-RPC session and an application session for
each application, before scripted bodies of 17 components and scripted applications, in one process and without sockets.
Time is virtual: it jumps to the next timer, so that twelve hours take minutes. Processor time is real, and charged to
the gateway whose work it is: its share of virtual time is the load of that gateway, and where it saturates follows.

`--real` has the same peers do the same before one gateway that is a process, over WebSockets and in real time.
"""

import argparse
import asyncio
from pathlib import Path
from typing import Final

from openrois_bench.simulation.clock import VirtualClock, install

COMMAND: Final = "openrois_bench.simulation"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=f"python -m {COMMAND}", description=__doc__)
    parser.add_argument("--bodies", type=int, default=100, help="(%(default)s)")
    parser.add_argument("--applications", type=int, default=1000, help="(%(default)s)")
    parser.add_argument("--gateways", type=int, default=16, help="that share them (%(default)s)")
    parser.add_argument(
        "--foreign", type=float, default=0.5, help="share of applications that dial another gateway (%(default)s)"
    )
    parser.add_argument(
        "--seeing-all", type=float, default=0.01, help="share of applications that see every body (%(default)s)"
    )
    parser.add_argument("--rush", type=float, default=10.0, help="seconds in which all work together (%(default)s)")
    parser.add_argument("--visit", type=float, default=15.0, help="seconds of events in a visit (%(default)s)")
    parser.add_argument("--rate", type=float, default=1.0, help="times as many events as usual (%(default)s)")
    parser.add_argument(
        "--pace", type=float, default=1.0, help="times faster than usual where one kind is measured (%(default)s)"
    )
    parser.add_argument("--hours", type=float, default=12.0, help="virtual hours of the day (%(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of all chance (%(default)s)")
    parser.add_argument("--real", action="store_true", help="one gateway that is a process, in real time")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures there")
    return parser


def main() -> int:
    """Simulate, or measure, and print what was found; return the exit status."""
    chosen = vars(_parser().parse_args())
    is_real, file = chosen.pop("real"), chosen.pop("json")
    clock = VirtualClock()
    if not is_real:
        install(clock)
    # Only now: a module keeps the clocks that it finds when it is imported.
    from openrois_bench.measuring.conditions import conditions, load
    from openrois_bench.measuring.result import write_result
    from openrois_bench.simulation.report import figures, printed
    from openrois_bench.simulation.run import measured, simulated
    from openrois_bench.simulation.world import Plan

    before = load()
    if is_real:
        plan = Plan(**chosen | {"gateways": 1, "hours": 0.0})
        campaign = asyncio.run(measured(plan))
    else:
        plan = Plan(**chosen)
        campaign = simulated(plan, clock)
    machine = conditions(before)
    found = figures(plan, campaign.phases, campaign.peak)
    print(f"{machine}\n\n{printed(found)}")
    write_result(file, COMMAND, machine, **found)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
