"""Rows of bars: a value with its 95th percentile behind it. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.charts.svg import FAINT, GRID, INK, Drawing, ticks

ROW, _BAR, _LABEL = 30, 14, 266


@dataclass(frozen=True, slots=True)
class Bar:
    """A row: what it is, in which colour, its `value`, and a higher one that is shown paler, if any."""

    label: str
    colour: str
    value: float
    high: float | None = None


def draw_rows(drawing: Drawing, x: float, y: float, width: float, bars: Sequence[Bar], unit: str) -> None:
    """Draw `bars` with their labels and an axis below, from the upper left at (`x`, `y`), `width` wide."""
    left, right = x + _LABEL, x + width - 70
    marks = ticks(max(max(bar.value, bar.high or 0) for bar in bars))
    scale = (right - left) / marks[-1]
    bottom = y + ROW * len(bars)
    for mark in marks:
        drawing.line([(left + mark * scale, y), (left + mark * scale, bottom)], GRID)
        last = f" {unit}" if mark == marks[-1] else ""
        drawing.text(left + mark * scale, bottom + 18, f"{mark:g}{last}", fill=FAINT, size=12, anchor="middle")
    for number, bar in enumerate(bars):
        top = y + ROW * number + (ROW - _BAR) / 2
        drawing.text(left - 12, top + _BAR - 2, bar.label, anchor="end")
        if bar.high is not None:
            drawing.box(left, top, bar.high * scale, _BAR, bar.colour + "44", radius=3)
        drawing.box(left, top, bar.value * scale, _BAR, bar.colour, radius=3)
        end = left + max(bar.value, bar.high or 0) * scale + 8
        told = f"{_short(bar.value)}" if bar.high is None else f"{_short(bar.value)} / {_short(bar.high)}"
        drawing.text(end, top + _BAR - 2, told, fill=INK, size=12)


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 100 else f"{value:.1f}"
