"""The chart of the fan-out: the sender's CPU by the number of viewers. Pure."""

import statistics
from typing import Any

from benchmarks.charts.svg import COLOURS, FAINT, GRID, INK, Drawing, spread, ticks

_NAMES = {"ours": "OpenRoIS", "aiortc": "aiortc, encoded once", "janus": "Janus", "pion": "pion"}
_LEFT, _RIGHT, _TOP, _BOTTOM = 70, 690, 110, 400


def draw(told: dict[str, Any]) -> str:
    """The chart of a result of `benchmarks.peers`."""
    kinds = {kind: _points(told, kind) for kind in _NAMES if kind in told["marginal"]}
    conditions = told["conditions"]
    drawing = Drawing(960, 450, "CPU of the sending process by the number of viewers")
    drawing.title(
        "What each further viewer costs the sender",
        "CPU in cores while one stream of 2.5 Mbit/s goes to all viewers, median of the runs; nobody encodes.",
        f"{conditions['cpus']} CPUs ({conditions['processor']}), load {conditions['load_before']:.1f} before and "
        f"{conditions['load_after']:.1f} after",
    )
    counts = sorted({count for points in kinds.values() for count, _ in points})
    up = ticks(max(cpu for points in kinds.values() for _, cpu in points))
    x_scale, y_scale = (_RIGHT - _LEFT) / counts[-1], (_BOTTOM - _TOP) / up[-1]

    def place(viewers: float, cpu: float) -> tuple[float, float]:
        return _LEFT + viewers * x_scale, _BOTTOM - cpu * y_scale

    for cpu in up:
        drawing.line([place(0, cpu), place(counts[-1], cpu)], GRID)
        drawing.text(_LEFT - 10, place(0, cpu)[1] + 4, f"{cpu:g}", fill=FAINT, size=12, anchor="end")
    for viewers in counts:
        drawing.text(place(viewers, 0)[0], _BOTTOM + 20, str(viewers), fill=FAINT, size=12, anchor="middle")
    drawing.text((_LEFT + _RIGHT) / 2, _BOTTOM + 40, "viewers", fill=FAINT, size=12, anchor="middle")
    highest_first = sorted(kinds, key=lambda kind: -kinds[kind][-1][1])
    labels = spread([place(*kinds[kind][-1])[1] for kind in highest_first], 36)
    for kind, label in zip(highest_first, labels, strict=True):
        points = [place(*point) for point in kinds[kind]]
        drawing.line(points, COLOURS[kind], 2.5)
        for x, y in points:
            drawing.dot(x, y, COLOURS[kind])
        drawing.text(points[-1][0] + 14, label + 1, _NAMES[kind], fill=COLOURS[kind], bold=True)
        cost = f"{told['marginal'][kind]:.1f} thousandths of a core each"
        drawing.text(points[-1][0] + 14, label + 17, cost, fill=INK, size=12)
    return str(drawing)


def _points(told: dict[str, Any], kind: str) -> list[tuple[int, float]]:
    runs = [run for run in told["runs"] if run["kind"] == kind]
    counts = sorted({run["viewers"] for run in runs})
    return [(count, statistics.median(run["cpu"] for run in runs if run["viewers"] == count)) for count in counts]
