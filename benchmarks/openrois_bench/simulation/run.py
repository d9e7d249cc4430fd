"""Runs a campaign: in a process whose clocks are virtual, or before a gateway that is a process."""

import asyncio
import gc
import sys
import time
from collections import Counter
from collections.abc import Callable
from typing import Final

from openrois_bench.simulation.books import ProcessBooks, SimulatedBooks
from openrois_bench.simulation.campaign import Campaign
from openrois_bench.simulation.clock import VirtualClock
from openrois_bench.simulation.gateways import simulated_gateways
from openrois_bench.simulation.loop import VirtualLoop
from openrois_bench.simulation.meter import Meter
from openrois_bench.simulation.phase import Phase
from openrois_bench.simulation.real import real_gateway
from openrois_bench.simulation.world import Plan, world

__all__ = ["measured", "simulated"]

_YOUNG: Final = 20_000
"""Objects between two looks for garbage, as in a gateway's process."""

_SELDOM: Final = 1000
"""Looks among younger objects before one at the oldest: those of all gateways together take a minute."""


def simulated(plan: Plan, clock: VirtualClock) -> Campaign:
    """Run a campaign in virtual time."""
    meter, counts = Meter(), Counter[str]()
    gc.collect()
    gc.freeze()
    gc.set_threshold(_YOUNG, 10, _SELDOM)

    async def simulate() -> Campaign:
        async with simulated_gateways(plan.gateways, counts) as gateways, world(plan, gateways, counts) as made:
            campaign = Campaign(made, SimulatedBooks(meter, gateways), _progress())
            await campaign.run()
            return campaign

    with meter.watching_collector(), asyncio.Runner(loop_factory=lambda: VirtualLoop(clock, meter)) as runner:
        return runner.run(simulate())


async def measured(plan: Plan) -> Campaign:
    """Run a campaign before one gateway over loopback, in real time."""
    async with real_gateway(plan) as gateway, world(plan, [gateway], Counter()) as made:
        campaign = Campaign(made, ProcessBooks(gateway.process), _progress())
        await campaign.run()
        return campaign


def _progress() -> Callable[[Phase], None]:
    began = time.process_time()

    def report(phase: Phase) -> None:
        told = ", ".join(f"{name} {count}" for name, count in phase.counts.items())
        print(
            f"{time.process_time() - began:7.1f} s  {phase.name:18} {phase.cpu:8.2f} s of gateways, "
            f"{phase.resident >> 20} MiB; {told}",
            file=sys.stderr,
            flush=True,
        )

    return report
