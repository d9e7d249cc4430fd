"""The chart of congestion: one viewer behind a narrow path beside fast ones. Pure."""

import statistics
from collections.abc import Iterator
from typing import Any

from benchmarks.charts.rows import ROW, Bar, draw_rows
from benchmarks.charts.svg import COLOURS, INK, Drawing

_ROWS = (
    ("openrois", "slow", "OpenRoIS, the slow one", COLOURS["ours"]),
    ("aiortc", "slow", "aiortc, the slow one alone", COLOURS["aiortc"]),
    ("openrois", "fast", "OpenRoIS, fast ones beside it", COLOURS["pion"]),
    ("fast alone", "fast", "OpenRoIS, fast ones alone", COLOURS["plain"]),
)
_HEAD, _TITLE, _AXIS = 82, 40, 34


def draw(told: dict[str, Any]) -> str:
    """The chart of a result of `benchmarks.slow_viewer`."""
    conditions = told["conditions"]
    panels = (
        ("Frames a second", list(_frames(told["results"])), ""),
        ("From capture to decoded, median / 95th percentile", list(_delays(told["results"])), "ms"),
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


def _frames(results: list[dict[str, Any]]) -> Iterator[Bar]:
    for label, colour, seen in _seen(results):
        yield Bar(label, colour, statistics.median(each["fps"] for each in seen))


def _delays(results: list[dict[str, Any]]) -> Iterator[Bar]:
    for label, colour, seen in _seen(results):
        # Who saw nothing has no delay.
        delays = [each["delay"] for each in seen if each["delay"] is not None]
        if delays:
            p50, p95 = (1000 * statistics.median(delay[name] for delay in delays) for name in ("p50", "p95"))
            yield Bar(label, colour, p50, p95)


def _seen(results: list[dict[str, Any]]) -> Iterator[tuple[str, str, list[dict[str, Any]]]]:
    """Each row's label and colour, and the figures of its viewers."""
    for loss in sorted({result["loss"] for result in results}):
        for way, viewers, words, colour in _ROWS:
            seen = [
                figures
                for result in results
                if (result["loss"], result["way"]) == (loss, way)
                for viewer, figures in result["seen"].items()
                if viewer.startswith(viewers)
            ]
            if seen:
                yield f"{words}, {loss:.0%} loss", colour, seen
