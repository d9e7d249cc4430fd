"""The chart of latency: from capture to viewer, in milliseconds. Pure."""

from typing import Any

from openrois_bench.charts.svg import COLOURS, INK, ROW, Bar, Drawing, draw_rows

_PANELS = {
    ("sink", "decoded"): "From capture to decoded, viewer without a screen",
    ("Chromium", "presented"): "From capture to presented, Chromium",
    ("Chromium", "connect"): "From connect_stream to the first picture, Chromium",
    ("Chromium", "resume"): "From resume_stream to a new picture, Chromium",
}
_WAYS = {"openrois": ("OpenRoIS", COLOURS["ours"]), "aiortc": ("aiortc alone", COLOURS["aiortc"])}
_HEAD, _TITLE, _AXIS = 82, 40, 34


def draw(told: dict[str, Any]) -> str:
    """The chart of a result of `openrois_bench.streams.latency`."""
    conditions = told["conditions"]
    panels = {title: bars for panel, title in _PANELS.items() if (bars := _bars(told["summary"], *panel))}
    height = _HEAD + sum(_TITLE + _AXIS + ROW * len(bars) for bars in panels.values()) + 16
    drawing = Drawing(960, height, "Latency from capture to viewer, beside aiortc alone")
    drawing.title(
        "How long a picture takes",
        "On one machine, H.264: median / 95th percentile. OpenRoIS with gateway and avatar adapter.",
        f"{conditions['cpus']} CPUs ({conditions['processor']}), load {conditions['load_before']:.1f} before and "
        f"{conditions['load_after']:.1f} after",
    )
    top: float = _HEAD
    for title, bars in panels.items():
        drawing.text(28, top + 28, title, fill=INK, bold=True)
        draw_rows(drawing, 28, top + _TITLE, 910, bars, "ms")
        top += _TITLE + _AXIS + ROW * len(bars)
    return str(drawing)


def _bars(summary: list[dict[str, Any]], viewer: str, measure: str) -> list[Bar]:
    return [
        Bar(f"{_WAYS[row['way']][0]}, {row['height']}p{row['fps']}", _WAYS[row["way"]][1], row["p50"], row["p95"])
        for row in summary
        if (row["viewer"], row["measure"]) == (viewer, measure)
    ]
