"""Hands: a palm, four fingers and a thumb that curl and spread."""

from math import cos, sin
from typing import Final

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Arm
from openrois_avatar.engines.figure.arms import Chain
from openrois_avatar.engines.puppet.canvas import Canvas, colour, hull, mixed
from openrois_avatar.engines.puppet.curves import Array, ribbon, ring, spline
from openrois_avatar.engines.puppet.view import Space

_FINGERS: Final = (
    # across, length, radius, knuckle (dm): from the little finger to the index finger
    (-0.215, 0.36, 0.070, 0.60),
    (-0.075, 0.47, 0.078, 0.66),
    (0.070, 0.51, 0.080, 0.68),
    (0.210, 0.45, 0.077, 0.64),
)
_THUMB: Final = np.asarray(((0.16, -0.05, 0.20), (0.37, -0.10, 0.46), (0.45, -0.13, 0.72)))
_PALM_OUTLINE = ring(
    (
        (-0.15, 0, -0.10),
        (-0.17, 0, 0.10),
        (-0.27, 0, 0.36),
        (-0.28, 0, 0.60),
        (-0.10, 0, 0.70),
        (0.10, 0, 0.72),
        (0.27, 0, 0.64),
        (0.28, 0, 0.40),
        (0.20, 0, 0.12),
        (0.15, 0, -0.10),
    ),
    steps=3,
)
_PALM = np.concatenate([_PALM_OUTLINE * (0.9, 1, 1) + (0, thick, 0) for thick in (-0.10, 0.10)] + [_PALM_OUTLINE])
_CREASE = spline(((0.14, -0.1, 0.56), (0.03, -0.12, 0.42), (0.01, -0.12, 0.20)))
_SKIN = colour(palette.SKIN)
_LINE = mixed(palette.SKIN, palette.LID_SHADE, 0.75)
_EDGE: Final = 0.018
"""How far (dm) a finger's outline goes beyond it."""


def draw_hand(canvas: Canvas, space: Space, bones: Chain, arm: Arm, way: Array) -> None:
    """The hand at the end of the solved right arm, mirrored with `way` (-1 or 1 for x)."""

    def placed(points: Array) -> Array:
        return (bones.wrist + points @ bones.hand.T) * way

    fingers = [placed(finger) for finger in finger_joints(arm.curl, arm.spread)]
    thumb, palm = placed(_thumb_joints(arm.curl, arm.spread)), hull(space(placed(_PALM)))
    palm_depth = float(placed(np.asarray(((0.0, 0.0, 0.4),)))[0, 1])
    behind = float(thumb[1:, 1].mean()) > palm_depth
    middle = palm.mean(axis=0)
    unit = space.pixels(1.0, thumb[:1])
    canvas.fill(middle + (palm - middle) * (1 + _EDGE * 3.2), _LINE)
    if behind:
        _draw_digit(canvas, space, thumb, (0.095, 0.086, 0.068), unit)
    for number in sorted(range(4), key=lambda number: -float(fingers[number][:, 1].mean())):
        radius = _FINGERS[number][2]
        _draw_digit(canvas, space, fingers[number], (radius, radius * 0.95, radius * 0.84), unit)
    canvas.shade(palm, middle, mixed(_SKIN, _LINE, 0.12), _SKIN, steps=4, reach=0.3)
    if not behind:
        _draw_digit(canvas, space, thumb, (0.095, 0.086, 0.068), unit)
    if bones.hand[1, 1] > 0.5:
        line = space(placed(_CREASE))
        canvas.fill(ribbon(line, unit * 0.012 * np.sin(np.linspace(0, np.pi, len(line)))), mixed(_SKIN, _LINE, 0.7))


def finger_joints(curl: float, spread: float) -> list[Array]:
    """Knuckle, middle joint and tip of every finger, little finger first, in the right hand's space."""
    joints = []
    for number, (across, length, _, knuckle) in enumerate(_FINGERS):
        fan, first, second = -spread * 0.30 * (number - 1.6), 1.15 * curl, 2.40 * curl
        steps = ((0.0, 0.0), (0.55 * length, first), (0.45 * length, second))
        y, z = np.cumsum([(-step * sin(angle), step * cos(angle)) for step, angle in steps], axis=0).T
        x = across + z * (0.10 * across / length) - z * sin(fan)
        joints.append(np.stack([x, y, knuckle + z * cos(fan)], axis=1))
    return joints


def _thumb_joints(curl: float, spread: float) -> Array:
    turn = 0.35 * spread - 0.30 * curl
    rest = _THUMB - _THUMB[0]
    x, z = rest[:, 0] * cos(turn) + rest[:, 2] * sin(turn), rest[:, 2] * cos(turn) - rest[:, 0] * sin(turn)
    bent = np.stack([x, rest[:, 1] - 0.35 * curl * np.arange(3) / 2, z], axis=1)
    return np.asarray(bent + _THUMB[0])


def _draw_digit(canvas: Canvas, space: Space, joints: Array, radii: tuple[float, float, float], unit: float) -> None:
    points = space(joints)
    for edge, paint in ((_EDGE, _LINE), (0.0, _SKIN)):
        first, second, third = ((radius + edge) * unit for radius in radii)
        canvas.limb(points[0], first, points[1], second, paint)
        canvas.limb(points[1], second, points[2], third, paint)
