"""Runs of `openrois bench fanout` in their order, and the comparison of their counts."""

import statistics
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple, Self

from openrois_streaming.codecs import H264, VP8
from pydantic import BaseModel, ConfigDict

__all__ = [
    "AIORTC",
    "BITRATE",
    "CODECS",
    "FPS",
    "HEIGHT",
    "OPENROIS",
    "WAYS",
    "WIDTH",
    "Comparison",
    "Planned",
    "Reading",
    "Run",
    "compare",
    "plan",
]

WIDTH: Final = 1280
HEIGHT: Final = 720
FPS: Final = 30
BITRATE: Final = 1_000_000
CODECS: Final = (VP8, H264)

OPENROIS: Final = "openrois"
AIORTC: Final = "aiortc"
WAYS: Final = (OPENROIS, AIORTC)
"""The two ways of sending that are compared."""

_DELIVERED: Final = 0.9


class Planned(NamedTuple):
    """One run: so many viewers of one sender."""

    round: int
    codec: str
    viewers: int
    way: str
    """The sender: `OPENROIS` or `AIORTC`."""


def plan(rounds: int, viewers: Sequence[int]) -> list[Planned]:
    """All runs in their order: what is compared runs one after the other, and in every round the other one first."""
    return [
        Planned(number, codec, count, way)
        for number in range(rounds)
        for codec in CODECS
        for count in viewers
        for way in (WAYS if number % 2 == 0 else reversed(WAYS))
    ]


class Reading(NamedTuple):
    """Counters of the sender and the receivers at one moment, and the busy time of the machine (s)."""

    sender: Mapping[str, Any]
    receivers: Mapping[str, Any]
    busy: float | None


class Run(BaseModel):
    """Cost of one run, and what it delivered."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    round: int
    codec: str
    viewers: int
    way: str
    cpu: float
    """CPU seconds of the sender's process per second: 1 is one core."""
    encoders: int
    fps: tuple[float, ...]
    """Of each viewer."""
    kbps: float
    """Of each viewer, on average: kilobits of pictures per second."""
    delivered: bool
    """Whether each viewer got at least nine tenths of the pictures."""
    others: float | None
    """CPU seconds per second that neither the sender nor the receivers used; None where that cannot be told."""

    @classmethod
    def of(cls, planned: Planned, before: Reading, after: Reading) -> Self:
        """The difference of two readings."""
        seconds = after.receivers["at"] - before.receivers["at"]
        counts = zip(before.receivers["pictures"], after.receivers["pictures"], strict=True)
        fps = tuple(round((to - since) / seconds, 1) for since, to in counts)[: planned.viewers]
        received = sum(after.receivers["bytes"]) - sum(before.receivers["bytes"])
        used = after.sender["cpu"] - before.sender["cpu"]
        others = None
        if before.busy is not None and after.busy is not None:
            ours = used + after.receivers["cpu"] - before.receivers["cpu"]
            others = max(0.0, round((after.busy - before.busy - ours) / seconds, 2))
        return cls(
            **planned._asdict(),
            cpu=round(used / (after.sender["at"] - before.sender["at"]), 4),
            encoders=after.sender["encoders"],
            fps=fps,
            kbps=round(received * 8 / 1000 / seconds / planned.viewers),
            delivered=min(fps) >= _DELIVERED * FPS,
            others=others,
        )


class Comparison(BaseModel):
    """OpenRoIS and aiortc with as many viewers of the same codec, over all rounds. What is said of each is by its name.

    `ratio` is the median of the ratios within a round, where the two ran one after the other; rounds in which one did
    not deliver are left out of it, for a sender that sends less costs less.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    codec: str
    viewers: int
    cpu: dict[str, float]
    """Medians."""
    ratio: float | None
    """Of the CPU of OpenRoIS to that of aiortc; None if there was no round in which both delivered."""
    fps: dict[str, float]
    """Medians of that of the viewer that got least."""
    kbps: dict[str, float]
    encoders: dict[str, int]
    """The most that ran at once."""
    delivered: dict[str, bool]
    """Whether every round did."""


def compare(runs: Sequence[Run]) -> tuple[Comparison, ...]:
    """Sum up the rounds; every run of the one has one of the other in its round."""
    cells = dict.fromkeys((run.codec, run.viewers) for run in runs)
    return tuple(_compare([run for run in runs if (run.codec, run.viewers) == cell]) for cell in cells)


def _compare(runs: Sequence[Run]) -> Comparison:
    by_way = {way: sorted((run for run in runs if run.way == way), key=lambda run: run.round) for way in WAYS}
    pairs = zip(by_way[OPENROIS], by_way[AIORTC], strict=True)
    ratios = [ours.cpu / theirs.cpu for ours, theirs in pairs if ours.delivered and theirs.delivered]
    return Comparison(
        codec=runs[0].codec,
        viewers=runs[0].viewers,
        cpu={way: statistics.median(run.cpu for run in its) for way, its in by_way.items()},
        ratio=round(statistics.median(ratios), 3) if ratios else None,
        fps={way: statistics.median(min(run.fps) for run in its) for way, its in by_way.items()},
        kbps={way: statistics.median(run.kbps for run in its) for way, its in by_way.items()},
        encoders={way: max(run.encoders for run in its) for way, its in by_way.items()},
        delivered={way: all(run.delivered for run in its) for way, its in by_way.items()},
    )
