"""`openrois bench idle`: cost of idle connections at a gateway."""

import asyncio
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from openrois_bench.errors import BenchFailed
from openrois_bench.gateway.deployment import deployed
from openrois_bench.gateway.load import applications
from openrois_bench.gateway.security import TLS, Security
from openrois_bench.measuring.conditions import Conditions, conditions, load
from openrois_bench.measuring.figures import Figures
from openrois_bench.processes.files import allow_files

__all__ = ["IdleReport", "IdleSettings", "run_idle"]

SPARE_FILES: Final = 128
"""Open files that a process has beside its connections."""

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class IdleSettings:
    """Settings of the measurement.

    Attributes:
        connections: that are open at a time.
        seconds: for which they stay open once all are.
        security: how the gateway is protected.
    """

    connections: int = 5000
    seconds: float = 10.0
    security: Security = TLS


class IdleReport(Figures):
    """Results.

    Attributes:
        empty: MiB of the gateway without applications.
        full: MiB with all of them.
        each: KiB for one.
        opening: connections that were opened a second.
        opening_us: microseconds of the gateway for opening one.
        cpu: share of a processor that the gateway needs while nothing happens.
    """

    bench: Literal["idle"] = "idle"
    conditions: Conditions
    security: str
    connections: int
    empty: float
    full: float
    each: float
    opening: float
    opening_us: float
    cpu: float

    def __str__(self) -> str:
        return "\n".join(
            (
                f"{self.conditions}\n{self.security}",
                "",
                f"{self.connections} idle connections: gateway {self.full:.0f} MiB ({self.empty:.0f} MiB without), "
                f"{self.each:.1f} KiB each; {self.cpu * 100:.1f} % of a processor",
                f"opened at {self.opening:.0f} a second, {self.opening_us:.0f} us of the gateway for each",
            )
        )


async def run_idle(settings: IdleSettings, progress: Progress) -> IdleReport:
    """Measure and return the report.

    Raises:
        BenchFailed: the system allows too few open files, or something did not do what it should.
    """
    allow_files(settings.connections + SPARE_FILES)
    before = load()
    async with deployed(settings.security, "--per-address", str(settings.connections + 1)) as deployment:
        gateway = deployment.gateway
        empty, cpu, began = gateway.memory(), gateway.cpu(), time.perf_counter()
        async with applications(deployment.door, settings.connections) as idle:
            took, opened = time.perf_counter() - began, gateway.cpu()
            progress(f"{len(idle)} connections after {took:.0f} s")
            await asyncio.sleep(settings.seconds)
            lost = sum(not application.is_open for application in idle)
            if lost:
                raise BenchFailed(f"the gateway ended {lost} of {len(idle)} connections on which nothing happened")
            full, resting = gateway.memory(), gateway.cpu() - opened
    return IdleReport(
        conditions=conditions(before),
        security=str(settings.security),
        connections=settings.connections,
        empty=round(empty, 1),
        full=round(full, 1),
        each=round((full - empty) * 1024 / settings.connections, 1),
        opening=round(settings.connections / took, 1),
        opening_us=round((opened - cpu) / settings.connections * 1e6, 1),
        cpu=round(resting / settings.seconds, 4),
    )
