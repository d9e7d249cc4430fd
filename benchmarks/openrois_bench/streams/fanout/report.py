"""Report of `openrois bench fanout`, for people and as JSON."""

import statistics
from typing import Literal

from pydantic import BaseModel, ConfigDict

from openrois_bench.measuring.conditions import Conditions
from openrois_bench.measuring.table import table
from openrois_bench.streams.fanout.runs import AIORTC, BITRATE, FPS, HEIGHT, OPENROIS, WIDTH, Comparison, Run

__all__ = ["FanoutReport"]


class FanoutReport(BaseModel):
    """All runs, and how they were made."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    bench: Literal["fanout"] = "fanout"
    conditions: Conditions
    seconds: float
    rounds: int
    width: int = WIDTH
    height: int = HEIGHT
    fps: int = FPS
    bitrate: int = BITRATE
    comparisons: tuple[Comparison, ...]
    runs: tuple[Run, ...]

    def __str__(self) -> str:
        head = ("codec", "viewers", "OpenRoIS CPU", "aiortc CPU", "ratio", "fps", "encoders")
        return "\n".join(
            (
                f"one stream of {WIDTH}x{HEIGHT} at {FPS} fps and {BITRATE / 1e6:g} Mbit/s to viewers on this machine; "
                f"{self.rounds} rounds of {self.seconds:g} s, interleaved",
                str(self.conditions),
                "",
                table(head, [_row(comparison) for comparison in self.comparisons]),
                "",
                "CPU: of the sender's process, median, 1 is one core; ratio: over the rounds in which both delivered;",
                "fps: of the viewer that got least, median, and encoders: running at once, both OpenRoIS / aiortc.",
                *self._others(),
                *(("* in some round a viewer got less than nine tenths of the pictures.",) if self._marked() else ()),
            )
        )

    def _others(self) -> tuple[str, ...]:
        others = [run.others for run in self.runs if run.others is not None]
        if not others:
            return ()
        return (f"Meanwhile other programs used {statistics.median(others):.2f} cores, {max(others):.2f} at most.",)

    def _marked(self) -> bool:
        return not all(all(comparison.delivered.values()) for comparison in self.comparisons)


def _row(each: Comparison) -> tuple[str, ...]:
    cpu = {way: f"{each.cpu[way]:.3f}" + ("" if each.delivered[way] else "*") for way in each.cpu}
    return (
        each.codec.removeprefix("video/"),
        str(each.viewers),
        cpu[OPENROIS],
        cpu[AIORTC],
        "-" if each.ratio is None else f"{each.ratio:.2f}",
        f"{each.fps[OPENROIS]:.0f} / {each.fps[AIORTC]:.0f}",
        f"{each.encoders[OPENROIS]} / {each.encoders[AIORTC]}",
    )
