"""Drawing in SVG, in the colours of the other pictures of the pages: boxes, lines, text, and rows of bars. Pure."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

INK, TEXT, FAINT, GRID = "#1b2840", "#44536b", "#7a8aa3", "#dde5ef"
COLOURS = {
    "ours": "#2f6fb3",
    "aiortc": "#c2562f",
    "janus": "#8a5fb0",
    "pion": "#3f8f63",
    "plain": "#8b97a8",
}
_HEAD = 11
"""Length of the head of an arrow."""


class Drawing:
    """Picture of `width` x `height` units; the origin is at the upper left.

    Args:
        width: of the picture.
        height: of the picture.
        label: description of the picture for screen readers.
    """

    def __init__(self, width: int, height: int, label: str) -> None:
        self._head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'font-family="system-ui, sans-serif" role="img" aria-label="{escape(label)}">'
        )
        self._lines: list[str] = []
        self.box(0, 0, width, height, "#f8fafc", radius=14)

    def box(
        self, x: float, y: float, width: float, height: float, fill: str, *, radius: float = 0, stroke: str = ""
    ) -> None:
        """A filled rectangle; `stroke` is the colour of its edge, if it has one."""
        rounded = f' rx="{_n(radius)}"' if radius else ""
        edge = f' stroke="{stroke}"' if stroke else ""
        self._lines.append(
            f'<rect x="{_n(x)}" y="{_n(y)}" width="{_n(width)}" height="{_n(height)}"{rounded} fill="{fill}"{edge}/>'
        )

    def line(self, points: Sequence[tuple[float, float]], stroke: str, width: float = 1) -> None:
        """A line through `points`."""
        path = "L".join(f"{_n(x)} {_n(y)}" for x, y in points)
        self._lines.append(
            f'<path d="M{path}" fill="none" stroke="{stroke}" stroke-width="{_n(width)}" stroke-linejoin="round"/>'
        )

    def arrow(self, x: float, y: float, end: float, stroke: str, *, both: bool = False) -> None:
        """A horizontal line from `x` with a head at `end`, and at `x` too where it leads `both` ways."""
        tips = [end, x] if both else [end]
        self.line([(x, y), (end, y)], stroke, 2)
        for tip in tips:
            back = math.copysign(_HEAD, (x + end) / 2 - tip)
            corners = ((tip, y), (tip + back, y - _HEAD / 2), (tip + back, y + _HEAD / 2))
            path = "L".join(f"{_n(across)} {_n(down)}" for across, down in corners)
            self._lines.append(f'<path d="M{path}z" fill="{stroke}"/>')

    def text(
        self,
        x: float,
        y: float,
        text: str,
        *,
        fill: str = TEXT,
        size: int = 13,
        bold: bool = False,
        code: bool = False,
        anchor: str = "",
    ) -> None:
        """A line of text; `anchor` is "middle" or "end", or nothing where it begins at `x`; `code`: in monospace."""
        weight = ' font-weight="600"' if bold else ""
        family = ' font-family="ui-monospace, monospace"' if code else ""
        anchored = f' text-anchor="{anchor}"' if anchor else ""
        style = f'font-size="{size}" fill="{fill}"{weight}{family}{anchored}'
        self._lines.append(f'<text x="{_n(x)}" y="{_n(y)}" {style}>{escape(text)}</text>')

    def title(self, title: str, *below: str) -> None:
        """Draw the title."""
        self.text(28, 38, title, fill=INK, size=18, bold=True)
        for number, line in enumerate(below):
            self.text(28, 60 + 18 * number, line, fill=TEXT)

    def __str__(self) -> str:
        return "\n".join([self._head, *(f"  {line}" for line in self._lines), "</svg>\n"])


def ticks(highest: float) -> list[float]:
    """Round numbers from 0 to at least `highest` (above 0), at most six."""
    for digit in (1, 2, 5, 10, 20, 50):
        step = digit * 10 ** math.floor(math.log10(highest / 5))
        if step * 5 >= highest:
            break
    return [round(step * number, 12) for number in range(math.ceil(highest / step - 1e-9) + 1)]


def _n(number: float) -> str:
    return f"{number:.1f}".rstrip("0").rstrip(".")


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
