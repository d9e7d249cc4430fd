"""Many gateways, bodies and applications in virtual time.

`python -m openrois_bench.simulation` runs the gateway's own code, a JSON-RPC session and an application session for
each application, before scripted bodies of 17 components and scripted applications, in one process and without sockets.
Time is virtual: it jumps to the next timer, so that twelve hours take minutes. Processor time is real, and charged to
the gateway whose work it is: its share of virtual time is the load of that gateway, and where it saturates follows.

`--real` has the same peers do the same before one gateway that is a process, over WebSockets and in real time.
"""

import argparse
import asyncio
import gc
import sys
import time
from collections import Counter
from collections.abc import Coroutine
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from openrois_bench.simulation.clock import VirtualClock, install

if TYPE_CHECKING:
    from openrois_bench.simulation.campaign import Campaign, Phase
    from openrois_bench.simulation.world import Plan

_YOUNG: Final = 20_000
"""Objects between two looks for garbage, as in a gateway's process."""

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
    # What follows finds the clocks that were installed.
    from openrois_bench.measuring.conditions import conditions, load
    from openrois_bench.measuring.result import write_result
    from openrois_bench.simulation.report import figures, printed
    from openrois_bench.simulation.world import Plan

    before = load()
    if is_real:
        plan = Plan(**chosen | {"gateways": 1, "hours": 0.0})
        campaign = asyncio.run(_measured(plan))
    else:
        plan = Plan(**chosen)
        campaign = _simulated(plan, clock)
    machine = conditions(before)
    found = figures(plan, campaign.phases, campaign.peak)
    print(f"{machine}\n\n{printed(found)}")
    write_result(file, COMMAND, machine, **found)
    return 0


def _simulated(plan: "Plan", clock: VirtualClock) -> "Campaign":
    from openrois_bench.simulation.books import SimulatedBooks
    from openrois_bench.simulation.campaign import Campaign
    from openrois_bench.simulation.gateways import simulated_gateways
    from openrois_bench.simulation.loop import VirtualLoop
    from openrois_bench.simulation.meter import Meter
    from openrois_bench.simulation.world import world

    meter, counts = Meter(), Counter[str]()
    gc.collect()
    gc.freeze()
    gc.set_threshold(_YOUNG, 10, 10)

    async def simulate() -> Campaign:
        async with simulated_gateways(plan.gateways, counts) as gateways, world(plan, gateways, counts) as made:
            campaign = Campaign(made, SimulatedBooks(meter, gateways), _progress())
            await campaign.run()
            return campaign

    with meter.watching_collector():
        return _run(simulate(), lambda: VirtualLoop(clock, meter))


def _run(work: "Coroutine[Any, Any, Campaign]", factory: Any) -> "Campaign":
    with asyncio.Runner(loop_factory=factory) as runner:
        return runner.run(work)


async def _measured(plan: "Plan") -> "Campaign":
    from openrois_bench.simulation.books import ProcessBooks
    from openrois_bench.simulation.campaign import Campaign
    from openrois_bench.simulation.real import real_gateway
    from openrois_bench.simulation.world import world

    async with real_gateway(plan) as gateway, world(plan, [gateway], Counter()) as made:
        campaign = Campaign(made, ProcessBooks(gateway.process), _progress())
        await campaign.run()
        return campaign


def _progress() -> "Callable[[Phase], None]":
    began = time.process_time()

    def report(phase: "Phase") -> None:
        told = ", ".join(f"{name} {count}" for name, count in phase.counts.items())
        print(
            f"{time.process_time() - began:7.1f} s  {phase.name:18} {phase.cpu:8.2f} s of gateways, "
            f"{phase.resident >> 20} MiB; {told}",
            file=sys.stderr,
            flush=True,
        )

    return report


if __name__ == "__main__":
    raise SystemExit(main())
