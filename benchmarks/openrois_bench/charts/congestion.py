"""The chart of congestion: one viewer behind a narrow path beside fast ones. Pure."""

from collections.abc import Iterator
from typing import Any

from openrois_bench.charts.svg import COLOURS, INK, ROW, Bar, Drawing, draw_rows

_ROWS = (
    ("openrois", "slow", "OpenRoIS, the slow one", COLOURS["ours"]),
    ("aiortc", "slow", "aiortc, the slow one alone", COLOURS["aiortc"]),
    ("openrois", "fast", "OpenRoIS, fast ones beside it", COLOURS["pion"]),
    ("fast alone", "fast", "OpenRoIS, fast ones alone", COLOURS["plain"]),
)
_HEAD, _TITLE, _AXIS = 82, 40, 34


def draw(told: dict[str, Any]) -> str:
    """The chart of a result of `openrois_bench.streams.slow_viewer`."""
    conditions = told["conditions"]
    panels = (
        ("Frames a second", list(_frames(told["summary"])), ""),
        ("From capture to decoded, median / 95th percentile", list(_delays(told["summary"])), "ms"),
    )
    drawing = Drawing(
        960,
        _HEAD + sum(_TITLE + _AXIS + ROW * len(bars) for _, bars, _ in panels) + 16,
        "Frame rate and delay of one slow viewer beside fast ones",
    )
    drawing.title(
        "One viewer behind 1 Mbit/s, three fast ones beside it",
        "20 ms on the way, with and without loss; one shared source. Medians of the runs.",
        f"{conditions['cpus']} CPUs ({conditions['processor']}), load {conditions['load_before']:.1f} before and "
        f"{conditions['load_after']:.1f} after",
    )
    top: float = _HEAD
    for title, bars, unit in panels:
        drawing.text(28, top + 28, title, fill=INK, bold=True)
        draw_rows(drawing, 28, top + _TITLE, 910, bars, unit)
        top += _TITLE + _AXIS + ROW * len(bars)
    return str(drawing)


def _frames(rows: list[dict[str, Any]]) -> Iterator[Bar]:
    for label, colour, row in _labelled(rows):
        yield Bar(label, colour, row["fps"])


def _delays(rows: list[dict[str, Any]]) -> Iterator[Bar]:
    for label, colour, row in _labelled(rows):
        # Without pictures there is no delay.
        if row["fps"]:
            yield Bar(label, colour, row["p50_ms"], row["p95_ms"])


def _labelled(rows: list[dict[str, Any]]) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Each row with its label and colour."""
    found = {(row["loss"], row["way"], row["viewers"]): row for row in rows}
    for loss in sorted({row["loss"] for row in rows}):
        for way, viewers, words, colour in _ROWS:
            if row := found.get((loss, way, viewers)):
                yield f"{words}, {loss:.0%} loss", colour, row
