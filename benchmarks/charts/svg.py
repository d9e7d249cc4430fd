"""A picture in SVG that is drawn line by line, in the colours of the other pictures of the pages. Pure."""

import math
from collections.abc import Sequence
from html import escape

INK, TEXT, FAINT, GRID = "#1b2840", "#44536b", "#7a8aa3", "#dde5ef"
COLOURS = {
    "ours": "#2f6fb3",
    "aiortc": "#c2562f",
    "janus": "#8a5fb0",
    "pion": "#3f8f63",
    "plain": "#8b97a8",
}


class Drawing:
    """A picture of so many units; the origin is at the upper left.

    Args:
        width: of the picture.
        height: of the picture.
        label: what it shows, for those who do not see it.
    """

    def __init__(self, width: int, height: int, label: str) -> None:
        self._head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'font-family="system-ui, sans-serif" role="img" aria-label="{escape(label)}">'
        )
        self._lines: list[str] = []
        self.box(0, 0, width, height, "#f8fafc", radius=14)

    def box(self, x: float, y: float, width: float, height: float, fill: str, *, radius: float = 0) -> None:
        """A filled rectangle."""
        rounded = f' rx="{_n(radius)}"' if radius else ""
        self._lines.append(
            f'<rect x="{_n(x)}" y="{_n(y)}" width="{_n(width)}" height="{_n(height)}"{rounded} fill="{fill}"/>'
        )

    def line(self, points: Sequence[tuple[float, float]], stroke: str, width: float = 1) -> None:
        """A line through `points`."""
        path = "L".join(f"{_n(x)} {_n(y)}" for x, y in points)
        self._lines.append(
            f'<path d="M{path}" fill="none" stroke="{stroke}" stroke-width="{_n(width)}" stroke-linejoin="round"/>'
        )

    def dot(self, x: float, y: float, fill: str) -> None:
        """A filled circle."""
        self._lines.append(f'<circle cx="{_n(x)}" cy="{_n(y)}" r="4" fill="{fill}"/>')

    def text(
        self, x: float, y: float, text: str, *, fill: str = TEXT, size: int = 13, bold: bool = False, anchor: str = ""
    ) -> None:
        """A line of text; `anchor` is "middle" or "end", or nothing where it begins at `x`."""
        weight = ' font-weight="600"' if bold else ""
        anchored = f' text-anchor="{anchor}"' if anchor else ""
        self._lines.append(
            f'<text x="{_n(x)}" y="{_n(y)}" font-size="{size}" fill="{fill}"{weight}{anchored}>{escape(text)}</text>'
        )

    def title(self, title: str, *below: str) -> None:
        """What the picture says, and under which conditions."""
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


def spread(wanted: Sequence[float], apart: float) -> list[float]:
    """`wanted`, which are in order, moved as little downwards as it takes for neighbours to be `apart`."""
    placed: list[float] = []
    for place in wanted:
        placed.append(max(place, placed[-1] + apart) if placed else place)
    return placed


def _n(number: float) -> str:
    return f"{number:.1f}".rstrip("0").rstrip(".")
