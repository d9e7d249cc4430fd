"""Report of `openrois bench stop`, for people and as JSON. Pure."""

from typing import Final, Literal

from openrois_bench.measuring.conditions import Conditions
from openrois_bench.measuring.figures import Figures, Percentiles
from openrois_bench.measuring.table import table

__all__ = ["DEAD_MAN_GOAL", "ENOUGH", "MARGIN", "Load", "Run", "StopReport"]

ENOUGH: Final = 0.9
"""Of the rates of a flood that a run has to reach, to count."""

MARGIN: Final = 50.0
"""Milliseconds by which the p99 of STOP may be above that of the idle run."""

DEAD_MAN_GOAL: Final = 500.0
"""Milliseconds after which a dead man's switch must have stopped what moves."""


class Load(Figures):
    """Load beside STOP: datagrams a second, and viewers in all."""

    name: str
    reports: float = 0
    strangers: float = 0
    viewers: int = 0


class Run(Figures):
    """Measurement under one load.

    Attributes:
        load: what was asked for.
        reports: authentic RTCP packets a second that were sent.
        peers: peer connections over which they were: the engine ends those that flood.
        strangers: datagrams a second of strangers that were sent.
        joined: viewers that joined and saw something.
        failed: viewers that did not.
        stops: how long STOP took.
        unconfirmed: times that STOP was not confirmed.
        dead_man: milliseconds from the gateway's last sign of life to the stop.
        adapter: cores that the adapter used.
        pictures: a second that the honest viewer had.
        viewer_ended: why its peer connection has ended; empty where it has not.
    """

    load: Load
    reports: float = 0
    peers: int = 0
    strangers: float = 0
    joined: int = 0
    failed: int = 0
    stops: Percentiles
    unconfirmed: int
    dead_man: tuple[float, ...] = ()
    adapter: float
    pictures: float
    viewer_ended: str = ""

    @property
    def shortfall(self) -> str:
        """Missing part of the load, as a clause; empty where the run counts."""
        short = []
        for name, reached, asked in (
            ("RTCP/s", self.reports, self.load.reports),
            ("stranger datagrams/s", self.strangers, self.load.strangers),
            ("joining viewers", self.joined, self.load.viewers),
        ):
            if reached < ENOUGH * asked:
                short.append(f"{reached:,.0f} of {asked:,.0f} {name}")
        return ", ".join(short)


class StopReport(Figures):
    """All runs, and how they were made; the first one is idle."""

    bench: Literal["stop"] = "stop"
    engine: str
    conditions: Conditions
    seconds: float
    pinned: bool
    runs: tuple[Run, ...]

    def __str__(self) -> str:
        head = ("load", "STOPs", "p50", "p99", "unconfirmed", "dead man")
        beside = ("RTCP/s", "strangers/s", "joined", "adapter CPU", "pictures/s")
        where = "gateway and adapter on one core, all others on another" if self.pinned else "all on one core"
        return "\n".join(
            (
                f"STOP beside hostile media, engine {self.engine}; {self.seconds:g} s each, in milliseconds; {where}",
                str(self.conditions),
                "",
                table((*head, *beside), [_row(run) for run in self.runs]),
                "",
                *(f"{run.load.name}: does not count, only {run.shortfall}" for run in self.runs if run.shortfall),
                *self.findings(),
            )
        )

    def findings(self) -> tuple[str, ...]:
        """Return what of the goals was not reached by the runs that count; one sentence where all were."""
        idle, *loaded = self.runs
        missed = []
        for run in (each for each in loaded if not each.shortfall):
            above = (run.stops.p99 - idle.stops.p99) / 1000
            if above > MARGIN:
                missed.append(f"{run.load.name}: p99 is {above:.0f} ms above idle, more than {MARGIN:.0f} ms")
        for run in self.runs:
            if run.viewer_ended:
                missed.append(f"{run.load.name}: the honest viewer's peer connection ended: {run.viewer_ended}")
            if run.unconfirmed:
                missed.append(f"{run.load.name}: {run.unconfirmed} STOPs were not confirmed")
            if run.dead_man and max(run.dead_man) > DEAD_MAN_GOAL:
                missed.append(f"{run.load.name}: a dead man's switch took {max(run.dead_man):.0f} ms")
        return tuple(missed) or ("all goals reached by the runs that count",)


def _row(run: Run) -> tuple[str, ...]:
    return (
        run.load.name,
        str(run.stops.count),
        f"{run.stops.p50 / 1000:.1f}",
        f"{run.stops.p99 / 1000:.1f}",
        str(run.unconfirmed),
        f"{max(run.dead_man):.0f}" if run.dead_man else "",
        f"{run.reports:,.0f}",
        f"{run.strangers:,.0f}",
        f"{run.joined}/{run.load.viewers}",
        f"{run.adapter:.2f}",
        f"{run.pictures:.1f}",
    )
