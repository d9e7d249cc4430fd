"""The mouth: two lips that take every shape of speech, and what shows between them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Mouth
from openrois_avatar.engines.puppet.canvas import Canvas, colour, mixed
from openrois_avatar.engines.puppet.curves import Array, ribbon
from openrois_avatar.engines.puppet.view import Space

_Z: Final = -0.605
_HALF_WIDTH: Final = 0.235
_OPENING: Final = 0.27
"""How far (dm) a fully open jaw takes the lower lip down."""
_U = np.linspace(-1, 1, 25)
"""Along the mouth, from one corner to the other."""
_MIDDLE = np.clip(1 - _U**2, 0, 1)
_BOW = 1 - 0.26 * np.exp(-((_U / 0.13) ** 2)) + 0.12 * np.exp(-(((np.abs(_U) - 0.32) / 0.16) ** 2))
_UPPER_LIP = mixed(palette.LIPS, palette.MOUTH_INSIDE, 0.10)
_LOWER_LIP = mixed(palette.LIPS, palette.BLUSH, 0.30)
_GLOSS = mixed(palette.LIPS, "#ffffff", 0.30)
_LOWER_TEETH = mixed(palette.TEETH, palette.MOUTH_INSIDE, 0.12)
_SEAM = mixed(palette.LIPS, palette.MOUTH_INSIDE, 0.62)


@dataclass(frozen=True)
class Lines:
    """Heights (dm, from the middle of the mouth) of the four edges of the lips along `x`."""

    x: Array
    top: Array
    upper: Array
    lower: Array
    bottom: Array


def lines(mouth: Mouth) -> Lines:
    """The lips in a shape."""
    x = _HALF_WIDTH * (1 - 0.42 * mouth.round) + 0.085 * mouth.wide + 0.050 * mouth.smile + 0.02 * mouth.press
    # A narrow mouth opens evenly, a wide one most in the middle.
    arch = _MIDDLE ** (0.70 - 0.22 * mouth.round)
    rest = (
        (0.022 + 0.075 * mouth.smile) * _U**2
        - 0.004 * np.exp(-((_U / 0.2) ** 2))
        - 0.4 * _OPENING * mouth.jaw * np.abs(_U) ** 3
    )
    drop = _OPENING * mouth.jaw * (1 - 0.55 * mouth.bite)
    upper = rest + arch * (0.055 * mouth.upper + 0.030 * mouth.round * min(1.0, mouth.jaw * 3) - 0.02 * mouth.smile)
    lower = rest - arch * (drop + 0.060 * mouth.lower + 0.02 * mouth.smile - 0.022 * mouth.bite)
    thin = 1 - 0.55 * mouth.press
    top = upper + _MIDDLE**0.70 * _BOW * (0.070 + 0.022 * mouth.round - 0.012 * mouth.wide) * thin
    bottom = lower - _MIDDLE**0.80 * (0.092 + 0.020 * mouth.round - 0.012 * mouth.wide) * thin * (1 - 0.10 * mouth.bite)
    return Lines(_U * x, top, np.maximum(upper, lower), lower, bottom)


def draw(canvas: Canvas, space: Space, mouth: Mouth) -> None:
    """The mouth in a shape."""
    lips, depth = lines(mouth), -0.86 - 0.06 * mouth.round

    def line(height: Array, x: Array | None = None) -> Array:
        across = lips.x if x is None else x
        return space(np.stack([across, depth + 1.1 * across**2, _Z + height], axis=1))

    unit = space.pixels(1.0)
    upper, lower = line(lips.upper), line(lips.lower)
    opening = np.concatenate([upper, lower[::-1]])
    if float((lips.upper - lips.lower).max()) > 0.012:
        with canvas.within(opening) as inner:
            _draw_inside(inner, line, lips, mouth, opening)
    canvas.fill(np.concatenate([lower, line(lips.bottom)[::-1]]), _LOWER_LIP)
    if mouth.bite > 0.1:
        high, low = (line(height, lips.x * 0.78) for height in _bitten(lips, mouth.bite))
        canvas.fill(np.concatenate([high, low[::-1]]), colour(palette.TEETH))
    canvas.fill(np.concatenate([line(lips.top), upper[::-1]]), _UPPER_LIP)
    gloss = line(lips.lower * 0.45 + lips.bottom * 0.55)[7:18]
    canvas.fill(
        ribbon(gloss, unit * 0.015 * np.sin(np.linspace(0, np.pi, len(gloss))) * (1 - 0.6 * mouth.press)), _GLOSS
    )
    canvas.fill(ribbon(upper, unit * 0.010 * np.sqrt(_MIDDLE + 0.1)), _SEAM)
    for corner in (upper[0], upper[-1]):
        canvas.disc(corner, unit * 0.016, _SEAM)


def _draw_inside(canvas: Canvas, line: Callable[..., Array], lips: Lines, mouth: Mouth, opening: Array) -> None:
    canvas.fill(opening, colour(palette.MOUTH_INSIDE))
    floor, teeth = float(lips.lower.min()), lips.x * 0.92
    if mouth.lower > 0.3 and mouth.jaw < 0.7:
        lower_teeth = np.concatenate(
            [line(lips.lower + 0.035 * mouth.lower, teeth), line(lips.lower - 0.05, teeth)[::-1]]
        )
        canvas.fill(lower_teeth, _LOWER_TEETH)
    tongue, rise = lips.x * (0.62 - 0.10 * mouth.tongue), 0.075 + 0.10 * mouth.tongue + 0.02 * mouth.jaw
    back = np.concatenate([line(floor + rise * np.sqrt(_MIDDLE), tongue), line(0 * _U + floor - 0.1, tongue)[::-1]])
    # The upper teeth stay with the skull while the lips move over them.
    edge = np.minimum(lips.upper, 0.07) - 0.052 + 0.36 * teeth**2 + 0.030 * mouth.round
    upper_teeth = np.concatenate([line(lips.upper + 0.05, teeth), line(edge, teeth)[::-1]])
    shown = [(upper_teeth, colour(palette.TEETH))]
    if mouth.jaw > 0.12:
        # Only for TH is the tongue in front of the teeth.
        shown.insert(1 if mouth.tongue > 0.8 else 0, (back, colour(palette.TONGUE)))
    for outline, paint in shown:
        canvas.fill(outline, paint)


def _bitten(lips: Lines, bite: float) -> tuple[Array, Array]:
    """Heights along the mouth of the upper teeth that rest on the lower lip."""
    return lips.upper, lips.upper - 0.040 * bite * _MIDDLE**0.3
