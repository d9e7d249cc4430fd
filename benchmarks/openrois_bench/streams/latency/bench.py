"""`openrois bench latency`: from the capture of a picture to the viewer, over gateway and adapter."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Final

from openrois_streaming.codecs import H264

from openrois_bench.errors import BenchFailed
from openrois_bench.measuring.conditions import conditions, load
from openrois_bench.processes.partner import partner
from openrois_bench.streams.latency.report import SINK, LatencyReport
from openrois_bench.viewing.adapter import COMPONENT_REF, Show
from openrois_bench.viewing.browser import chromium_version, watch_in_chromium
from openrois_bench.viewing.observation import Observation, Order, Sightings
from openrois_bench.viewing.product import product

__all__ = ["LatencySettings", "avatar", "patience", "run_latency", "watch_in_sink"]

_VIEWER_START: Final = 20.0
_RUN: Final = 4.0
"""Seconds that a viewer may take at most to start, and for connecting, suspending and resuming once."""


@dataclass(frozen=True, slots=True)
class LatencySettings:
    """Settings of the measurement.

    Attributes:
        seconds: for which each viewer plays.
        runs: how often each viewer connects, and how often it suspends and resumes.
        sizes: of the pictures, in pixels.
        chromium: path of a browser; None leaves it out.
    """

    seconds: float = 6.0
    runs: int = 7
    sizes: tuple[tuple[int, int], ...] = ((640, 360), (1280, 720))
    chromium: str | None = None


async def run_latency(settings: LatencySettings, progress: Callable[[str], None]) -> LatencyReport:
    """Measure; `progress` is told what comes next.

    Raises:
        BenchFailed: something did not do what it should.
    """
    versions = {} if settings.chromium is None else {"Chromium": await chromium_version(settings.chromium)}
    before = load()
    observations: list[Observation] = []
    for width, height in settings.sizes:
        async with avatar(width, height) as host:
            order = Order(
                url=f"ws://{host}/",
                component_ref=COMPONENT_REF,
                codec=H264,
                seconds=settings.seconds,
                runs=settings.runs,
                resumes=settings.runs,
            )
            progress(f"{width}x{height}: {SINK}")
            observations.append(_sum_up(SINK, await watch_in_sink(order)))
            if settings.chromium is not None:
                progress(f"{width}x{height}: Chromium")
                seen = await watch_in_chromium(settings.chromium, order, patience=patience(order))
                observations.append(_sum_up("Chromium", seen))
    return LatencyReport(
        seconds=settings.seconds,
        runs=settings.runs,
        conditions=conditions(before, versions),
        observations=tuple(observations),
    )


async def watch_in_sink(order: Order) -> Sightings:
    """Have a measuring sink do what is ordered, in a process of its own.

    Raises:
        BenchFailed: it could not.
    """
    async with partner("openrois_bench.viewing.sink_viewer") as viewer:
        told = await viewer.ask("watch", order.model_dump(mode="json"), within=patience(order))
    return Sightings.model_validate(told)


def _sum_up(viewer: str, seen: Sightings) -> Observation:
    try:
        return Observation.of(viewer, H264, seen)
    except ValueError as error:
        raise BenchFailed(f"{viewer}, {len(seen.numbers)} pictures, {seen.unreadable} unreadable: {error}") from error


def patience(order: Order) -> float:
    """Seconds that a viewer may take for what is ordered."""
    return _VIEWER_START + order.settling + order.seconds + max(order.runs, order.resumes) * _RUN


@asynccontextmanager
async def avatar(width: int, height: int, fps: float = 30, show: Show = "bars") -> AsyncIterator[str]:
    """Run a gateway and, behind it, an adapter with such pictures; yields the gateway's `host:port`.

    Raises:
        BenchFailed: it does not start.
    """
    async with product(width, height, fps, show) as served:
        yield served.host
