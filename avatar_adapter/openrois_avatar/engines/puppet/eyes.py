"""Eyes that look, blink and squint, and their brows."""

from math import cos, sin
from typing import Final

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.puppet.canvas import Canvas, colour, mixed
from openrois_avatar.engines.puppet.curves import Array, ribbon, spline
from openrois_avatar.engines.puppet.view import View

_X, _Z = 0.355, -0.085
"""The middle of the left eye."""
_OUTWARDS, _INWARDS = 0.255, 0.225
_HIGH, _LOW, _SHUT = 0.198, 0.135, -0.085
"""How far the lids are from the line between the corners: open above and below, and where they meet."""
_IRIS: Final = 0.168
_BALL: Final = 0.36
_CONVERGENCE: Final = 0.045
_T = np.linspace(-1, 1, 21)
"""Along the eye, from its inner corner to its outer one."""
_ARCH = (1 - _T**2) ** 0.72
_CORNERS = np.interp(_T, (-1, 1), (-0.040, 0.035))
_SKIN = colour(palette.SKIN)
_LASH = colour(palette.LASH)
_LID = mixed(palette.SKIN, palette.LID_SHADE, 0.30)
_CREASE = mixed(palette.SKIN, palette.LID_SHADE, 0.95)


def draw(canvas: Canvas, view: View, pose: Pose, side: int) -> None:
    """One eye with its brow; side +1 is the avatar's left."""
    lid = min(max(pose.lid_left if side > 0 else pose.lid_right, -0.2), 1.0)
    upper, lower = lids(lid, pose.squint, pose.wide)
    opening = np.concatenate([_placed(view, _T, upper, side), _placed(view, _T, lower, side)[::-1]])
    crease = np.maximum(upper + 0.045, upper * 0.35 + (_CORNERS + _HIGH * _ARCH) * 0.65 + 0.05)
    canvas.fill(np.concatenate([_placed(view, _T, crease, side), _placed(view, _T, upper, side)[::-1]]), _LID)
    if lid < 0.97:
        with canvas.within(opening) as inner:
            _draw_ball(inner, view, pose, side, opening, _placed(view, _T, upper - 0.035, side))
    unit = view.head.pixels(1.0)
    canvas.fill(ribbon(_placed(view, _T, crease, side), unit * 0.010 * np.sqrt(_ARCH)), _CREASE)
    canvas.fill(ribbon(_placed(view, _T, lower, side), unit * 0.008 * _ARCH), mixed(_LASH, _SKIN, 0.45))
    _draw_lashes(canvas, view, upper, lid, side)
    _draw_brow(canvas, view, pose, side)


def lids(lid: float, squint: float, wide: float) -> tuple[Array, Array]:
    """Heights (dm, from the middle of the eye) of the upper and the lower lid along the eye."""
    high = _HIGH * (1 + 0.20 * wide - 0.10 * squint)
    low = -_LOW * (1 + 0.12 * wide - 0.48 * squint)
    upper = high + (_SHUT - high) * lid
    lower = low + (_SHUT - low) * max(lid, 0.0)
    return _CORNERS + max(upper, lower) * _ARCH, _CORNERS + lower * _ARCH


def _placed(view: View, along: Array, height: Array, side: int) -> Array:
    """Points of the eye (along -1..1, height in dm) in pixels."""
    x = _X + np.where(along > 0, along * _OUTWARDS, along * _INWARDS)
    depth = -0.80 + 0.30 * x**2
    return view.head(np.stack([x * side, depth, _Z + height], axis=1))


def _draw_ball(canvas: Canvas, view: View, pose: Pose, side: int, opening: Array, shadow: Array) -> None:
    canvas.fill(opening, colour(palette.SCLERA))
    yaw, pitch = pose.gaze_yaw - side * _CONVERGENCE, pose.gaze_pitch
    centre = np.asarray((_X * side, -0.78 + _BALL, _Z + 0.02))
    direction = np.asarray((sin(yaw) * cos(pitch), -cos(yaw) * cos(pitch), sin(pitch)))
    middle, unit = view.head((centre + direction * _BALL)[None])[0], view.head.pixels(1.0)
    iris = unit * _IRIS
    canvas.disc(middle, iris, colour(palette.IRIS_DARK))
    for step in range(5):
        share = step / 4
        canvas.disc(
            middle + np.asarray((0.0, iris * 0.30 * share)),
            iris * (0.90 - 0.42 * share),
            mixed(palette.IRIS, palette.IRIS_BRIGHT, share**1.2 * 0.95),
        )
    canvas.disc(middle, iris * 0.46, mixed(palette.IRIS_DARK, "#05090c", 0.75))
    # The upper lid throws a shadow on the ball.
    canvas.shadow(np.concatenate([shadow, shadow[::-1] - np.asarray((0.0, unit * 0.12))]), _LASH, 70)
    canvas.disc(middle - iris * np.asarray((0.36, 0.38)), iris * 0.25, (255, 255, 255))
    canvas.disc(middle + iris * 0.40, iris * 0.12, (240, 255, 250))


def _draw_lashes(canvas: Canvas, view: View, upper: Array, lid: float, side: int) -> None:
    along = np.concatenate([_T, (1.12, 1.26)])
    height = np.concatenate([upper + 0.008, (0.062 - 0.05 * lid, 0.105 - 0.10 * lid)])
    widths = np.interp(along, (-1, -0.4, 0.5, 0.95, 1.26), (0.006, 0.017, 0.026, 0.026, 0.001))
    canvas.fill(ribbon(_placed(view, along, height, side), widths * view.head.pixels(1.0)), _LASH)


def _draw_brow(canvas: Canvas, view: View, pose: Pose, side: int) -> None:
    brow = pose.brow_left if side > 0 else pose.brow_right
    rise = 0.105 * brow
    line = spline(
        (
            (0.145 - 0.025 * pose.frown, -0.78, 0.245 + rise * 0.8 - 0.085 * pose.frown),
            (0.27, -0.78, 0.305 + rise - 0.04 * pose.frown),
            (0.43, -0.74, 0.325 + rise),
            (0.575, -0.70, 0.270 + rise * 0.8),
            (0.665, -0.66, 0.205 + rise * 0.6),
        )
    ) * np.asarray((side, 1, 1))
    widths = np.interp(np.linspace(0, 1, len(line)), (0, 0.08, 0.45, 1), (0.012, 0.027, 0.028, 0.002))
    canvas.fill(ribbon(view.head(line), widths * view.head.pixels(1.0)), colour(palette.BROW))
