"""Report of `openrois bench latency`, for people and as JSON. Pure."""

from typing import Final, Literal

from pydantic import BaseModel, ConfigDict

from openrois_bench.measuring.conditions import Conditions
from openrois_bench.measuring.table import table
from openrois_bench.viewing.observation import MEASURES, Observation

__all__ = ["SINK", "LatencyReport"]

SINK: Final = "sink"
"""What the viewer on `MeasuringSink` is called."""

_FPS: Final = 30


class LatencyReport(BaseModel):
    """All observations, and how they were made."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    bench: Literal["latency"] = "latency"
    conditions: Conditions
    seconds: float
    runs: int
    fps: int = _FPS
    observations: tuple[Observation, ...]

    def __str__(self) -> str:
        rows = [row for observation in self.observations for row in _rows(observation)]
        return "\n".join(
            (
                f"gateway, adapter and viewers as processes of their own; {self.seconds:g} s and {self.runs} runs each",
                str(self.conditions),
                "",
                table(("viewer", "pictures", "milliseconds", "median", "p95", "of"), rows),
                "",
                *(_counts(observation) for observation in self.observations),
                *self._notes(),
            )
        )

    def _notes(self) -> tuple[str, ...]:
        sink = f"{SINK}: a viewer without a screen, in Python; a picture is there as soon as it is decoded."
        chromium = "Chromium: presented is when the browser expects the picture on the screen."
        if any(observation.viewer == "Chromium" for observation in self.observations):
            return sink, chromium
        return sink, "Chromium is not installed, so there are no figures of a browser."


def _rows(seen: Observation) -> list[tuple[str, ...]]:
    pictures = f"{seen.width}x{seen.height} {seen.codec.removeprefix('video/')}"
    return [
        (seen.viewer, pictures, text, f"{found.p50:.1f}", f"{found.p95:.1f}", str(found.count))
        for name, text in MEASURES.items()
        if (found := seen.milliseconds.get(name))
    ]


def _counts(seen: Observation) -> str:
    return (
        f"{seen.viewer} {seen.width}x{seen.height}: {seen.pictures} pictures seen, {seen.missed} missed, "
        f"{seen.unreadable} without a readable stamp."
    )
