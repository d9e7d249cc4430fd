"""Legs that step: what is seen of a figure from farther away."""

from collections.abc import Sequence

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.figure.rig import ANKLE, HIP, KNEE, Leg
from openrois_avatar.engines.puppet.canvas import Canvas, Colour, colour, mixed
from openrois_avatar.engines.puppet.curves import Array
from openrois_avatar.engines.puppet.view import Space, View

_LEGS: Sequence[tuple[int, tuple[Leg, Leg, Leg]]] = (
    (1, ("thigh_left", "shin_left", "foot_left")),
    (-1, ("thigh_right", "shin_right", "foot_right")),
)
_HEEL, _TOE = ANKLE + np.asarray((0.0, 0.05, -0.26)), ANKLE + np.asarray((0.0, -0.62, -0.28))
_RADII = (0.46, 0.34, 0.26)
"""Of the trousers at hip, knee and ankle, in dm."""


def draw(canvas: Canvas, view: View, trousers: str, shoes: str) -> None:
    """Both legs in these colours, the farther one first."""
    for side, spaces in sorted(_LEGS, key=lambda leg: -_depth(view.legs[leg[1][2]], leg[0])):
        _draw_leg(canvas, [view.legs[space] for space in spaces], side, trousers, shoes)


def _draw_leg(canvas: Canvas, spaces: Sequence[Space], side: int, trousers: str, shoes: str) -> None:
    thigh, shin, foot = spaces
    way = np.asarray((side, 1.0, 1.0))
    joints = np.concatenate([thigh(HIP[None] * way), shin(KNEE[None] * way), foot(ANKLE[None] * way)])
    radii = [thigh.pixels(radius, HIP[None] * way) for radius in _RADII]
    unit = foot.pixels(1.0, ANKLE[None] * way)
    heel, toe = foot(np.stack([_HEEL, _TOE]) * way)
    canvas.limb(heel, 0.20 * unit, toe, 0.17 * unit, colour(shoes))
    for share, paint in _tones(trousers):
        for start, end in ((0, 1), (1, 2)):
            canvas.limb(joints[start], radii[start] * share, joints[end], radii[end] * share, paint)


def _tones(trousers: str) -> list[tuple[float, Colour]]:
    """Shares of a leg's width and their colours, from its edge to its middle."""
    edge, middle = mixed(trousers, palette.LASH, 0.35), mixed(trousers, palette.COLLAR, 0.10)
    return [(1 - 0.16 * step, mixed(edge, middle, step / 3)) for step in range(4)]


def _depth(foot: Space, side: int) -> float:
    there: Array = foot.frame.rotation @ (ANKLE * (side, 1.0, 1.0)) + foot.frame.origin
    return float(there[1])
