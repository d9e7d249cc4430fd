"""The hair: a bob with a parting on the picture's left, its fringe swept to the right."""

from typing import Final

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.puppet.canvas import Canvas, Colour, mixed
from openrois_avatar.engines.puppet.curves import Points, even, mirrored, ribbon, ring
from openrois_avatar.engines.puppet.view import View

_DEEP = mixed(palette.HAIR, palette.LASH, 0.55)
_EDGE = mixed(palette.HAIR, palette.LASH, 0.26)
_LIGHT = mixed(palette.HAIR, "#d69a72", 0.22)
_SHINE = mixed(palette.HAIR, "#e0a67c", 0.46)
_SAMPLES: Final = 30
"""Points along each side of a lock."""

# Every point is (x, depth, z) in head space.
_BACK = (
    (0.55, 0.2, 1.24),
    (0.95, 0.2, 0.84),
    (1.08, 0.2, 0.25),
    (1.09, 0.2, -0.30),
    (1.00, 0.2, -0.70),
    (0.82, 0.2, -0.88),
    (0.45, 0.3, -0.83),
)
_BEHIND = ring(((0.0, 0.2, 1.37), *_BACK, (0.0, 0.3, -0.79), *mirrored(_BACK)), 4)
_PARTING = (-0.33, -0.52, 1.06)
_CROWN = ((-0.31, -0.28, 1.22), (-0.24, 0.05, 1.38))
_SWEPT = (
    # the side to the face, and the outer side, from the parting to the tips
    (
        _PARTING,
        (-0.06, -0.82, 0.84),
        (0.30, -0.84, 0.60),
        (0.60, -0.64, 0.27),
        (0.785, -0.38, -0.10),
        (0.83, -0.25, -0.50),
        (0.72, -0.18, -0.90),
    ),
    (
        _PARTING,
        *_CROWN,
        (0.12, 0.1, 1.405),
        (0.56, 0.1, 1.27),
        (0.97, 0.1, 0.86),
        (1.12, 0.1, 0.25),
        (1.14, 0.1, -0.30),
        (1.06, 0.05, -0.74),
        (0.90, -0.02, -0.98),
    ),
)
_TUCKED = (
    (
        _PARTING,
        (-0.50, -0.66, 0.86),
        (-0.68, -0.50, 0.56),
        (-0.80, -0.22, 0.20),
        (-0.87, -0.02, -0.10),
        (-0.85, 0.0, -0.50),
        (-0.72, 0.0, -0.90),
    ),
    (
        _PARTING,
        *_CROWN,
        (-0.60, 0.1, 1.25),
        (-0.98, 0.1, 0.86),
        (-1.11, 0.1, 0.25),
        (-1.13, 0.1, -0.30),
        (-1.05, 0.05, -0.74),
        (-0.90, 0.0, -0.97),
    ),
)


class _Lock:
    """Hair between two sides, with its light and its strands, as one array of points and the pieces it consists of."""

    def __init__(
        self, inner: Points, outer: Points, strands: tuple[tuple[float, float, float, float, Colour], ...]
    ) -> None:
        self._sides = np.stack([even(inner, _SAMPLES), even(outer, _SAMPLES)])
        self._bands = [(share, mixed(_EDGE, _LIGHT, share / 0.42)) for share in np.linspace(0, 0.42, 6).tolist()]
        self._strands = strands

    def draw(self, canvas: Canvas, view: View) -> None:
        inner, outer = (view.round(side) for side in self._sides)
        unit = view.round.pixels(1.0)
        for share, paint in self._bands:
            canvas.fill(
                np.concatenate([inner + (outer - inner) * share, (outer + (inner - outer) * share)[::-1]]), paint
            )
        for across, start, end, width, paint in self._strands:
            part = slice(round(start * _SAMPLES), round(end * _SAMPLES))
            line = (inner + (outer - inner) * across)[part]
            canvas.fill(ribbon(line, unit * width * np.sin(np.linspace(0, np.pi, len(line)))), paint)


class Hair:
    """The hair; it never changes its shape."""

    def __init__(self) -> None:
        dark, darker = mixed(palette.HAIR, _DEEP, 0.45), mixed(palette.HAIR, _DEEP, 0.65)
        # across the lock, start and end along it, half width in dm, colour
        swept = _Lock(
            *_SWEPT,
            (
                (0.16, 0.02, 0.97, 0.017, dark),
                (0.34, 0.04, 0.99, 0.022, darker),
                (0.56, 0.03, 0.97, 0.020, dark),
                (0.78, 0.06, 0.95, 0.018, dark),
                (0.44, 0.20, 0.52, 0.042, _SHINE),
                (0.68, 0.24, 0.50, 0.034, _SHINE),
                (0.24, 0.22, 0.46, 0.024, _SHINE),
            ),
        )
        tucked = _Lock(
            *_TUCKED,
            (
                (0.30, 0.03, 0.98, 0.017, dark),
                (0.62, 0.04, 0.96, 0.018, darker),
                (0.46, 0.24, 0.54, 0.030, _SHINE),
                (0.78, 0.26, 0.50, 0.020, _SHINE),
            ),
        )
        self._locks = (tucked, swept)

    def draw_behind(self, canvas: Canvas, view: View) -> None:
        """Draw the hair behind the neck."""
        canvas.fill(view.round(_BEHIND), _DEEP)

    def draw_back(self, canvas: Canvas, view: View) -> None:
        """The back of the head, over all of the face."""
        outline = view.round(_BEHIND)
        canvas.shade(outline, outline.mean(axis=0), _EDGE, _LIGHT, steps=6, reach=0.5)

    def draw_before(self, canvas: Canvas, view: View) -> None:
        """Draw the locks before the face and at its sides."""
        for lock in self._locks:
            lock.draw(canvas, view)
