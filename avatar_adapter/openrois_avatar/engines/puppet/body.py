"""Neck, jumper and collar."""

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.curves import smooth
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure.rig import shoulder_lift
from openrois_avatar.engines.puppet.canvas import Canvas, colour, mixed, spot
from openrois_avatar.engines.puppet.curves import Array, Points, ellipse, even, mirrored, ribbon, spline
from openrois_avatar.engines.puppet.view import View

_SKIN_SHADE = mixed(palette.SKIN, palette.LID_SHADE, 0.55)
_CLOTH = colour(palette.JUMPER)
_CLOTH_DARK = mixed(palette.JUMPER, palette.IRIS_DARK, 0.38)
_CLOTH_EDGE = mixed(palette.JUMPER, palette.IRIS_DARK, 0.26)
_CLOTH_LIGHT = mixed(palette.JUMPER, palette.IRIS_BRIGHT, 0.26)
_NAPE = mixed(palette.COLLAR, palette.LID_SHADE, 0.5)
_COLLAR_SHADE = mixed(palette.COLLAR, palette.LID_SHADE, 0.32)

# Every point is (x, depth, z) in body space.
_SIDE = (
    (0.30, 0.1, -1.25),
    (0.62, 0.15, -1.42),
    (0.98, 0.2, -1.58),
    (1.22, 0.2, -1.80),
    (1.22, 0.1, -2.20),
    (1.06, 0.0, -2.70),
)
_BELOW_THE_PICTURE = (1.05, 0.0, -3.60)
_HEM = ((1.02, 0.05, -4.00), (1.00, 0.10, -4.85), (0.92, 0.10, -5.02))


class _Jumper:
    """The jumper's outline, and how each of its points follows shoulders and breath."""

    def __init__(self, side: Points) -> None:
        self._rest = np.concatenate([spline(side, 4), mirrored(spline(side, 4))])
        self._lifted = {
            side: np.asarray(
                [smooth((x * side - 0.30) / 0.75) * min(max((z + 3.0) / 0.9, 0.0), 1.0) for x, _, z in self._rest]
            )
            for side in (1, -1)
        }
        self._breathing = 0.030 * np.clip((self._rest[:, 2] + 3.3) / 1.2, 0, 1)

    def outline(self, pose: Pose) -> Array:
        """With the shoulders lifted and the chest filled by breath, (n, 3)."""
        moved = self._rest.copy()
        for side, share in self._lifted.items():
            moved[:, 2] += share * shoulder_lift(pose, side)
        moved[:, 0] *= 1 + 0.012 * pose.breath
        moved[:, 2] += pose.breath * self._breathing
        return moved


_CLOSE, _WHOLE = _Jumper((*_SIDE, _BELOW_THE_PICTURE)), _Jumper((*_SIDE, *_HEM))
_NECK_SIDE = spline(((0.46, 0.1, -1.10), (0.58, 0.0, -1.40), (0.36, -0.25, -1.66), (0.0, -0.32, -1.74)), 4)
_NECKLINE = np.concatenate([_NECK_SIDE, mirrored(_NECK_SIDE)])
_LEAF = np.stack(
    [
        # the edge at the neck, and the edge on the jumper, from nape to throat
        even(((0.46, 0.15, -1.10), (0.53, 0.0, -1.32), (0.39, -0.22, -1.56), (0.02, -0.32, -1.70)), 24),
        even(
            (
                (0.46, 0.15, -1.10),
                (0.66, 0.1, -1.18),
                (0.78, 0.0, -1.42),
                (0.70, -0.1, -1.66),
                (0.42, -0.3, -1.86),
                (0.14, -0.34, -1.84),
                (0.02, -0.32, -1.70),
            ),
            24,
        ),
    ]
)
_FOLD = spline(((0.16, -0.34, -1.80), (0.42, -0.3, -1.81), (0.67, -0.1, -1.63), (0.74, 0.0, -1.42)))


class Body:
    """The body without its arms, up to the neck, with its soft light prepared for so many pixels per decimetre."""

    def __init__(self, scale: float) -> None:
        self._light = spot((1.05 * scale, 1.15 * scale), _CLOTH_LIGHT, 0.85)

    def draw(self, canvas: Canvas, view: View, pose: Pose, whole: bool = False) -> None:
        """Jumper, neck and collar; the jumper down to its hem only if the `whole` figure is seen."""
        canvas.fill(view.body(ellipse((0.0, 0.35, -1.20), (0.60, 0.16))), _NAPE)
        torso = view.body((_WHOLE if whole else _CLOSE).outline(pose))
        middle = view.body(((0.0, -0.3, -2.35),))[0]
        canvas.shade(torso, middle, _CLOTH_EDGE, _CLOTH, steps=6, reach=0.16)
        canvas.stamp(self._light, middle)
        _draw_neck(canvas, view)
        for side in (-1, 1):
            _draw_collar(canvas, view, pose, side)


def _draw_neck(canvas: Canvas, view: View) -> None:
    jaw = view.head(((0.40, 0.0, -0.45), (0.37, 0.10, -0.80)))
    other_jaw = view.head(((-0.37, 0.10, -0.80), (-0.40, 0.0, -0.45)))
    neck = np.concatenate([jaw, view.body(_NECKLINE), other_jaw])
    canvas.fill(neck, colour(palette.SKIN))
    chin = view.round(ellipse((0.0, -0.30, -0.86), (0.62, 0.42)))
    with canvas.within(neck) as shadow:
        shadow.shade(chin, chin.mean(axis=0), mixed(palette.SKIN, _SKIN_SHADE, 0.2), _SKIN_SHADE, steps=5, reach=0.30)
        hollow = view.body(ellipse((0.0, -0.3, -1.62), (0.07, 0.035)))
        shadow.shade(
            hollow,
            hollow.mean(axis=0),
            mixed(palette.SKIN, _SKIN_SHADE, 0.1),
            mixed(palette.SKIN, _SKIN_SHADE, 0.6),
            steps=4,
        )


def _draw_collar(canvas: Canvas, view: View, pose: Pose, side: int) -> None:
    way, rise = np.asarray((side, 1.0, 1.0)), np.asarray((0.0, 0.0, 0.018 * pose.breath))
    inner, outer = (view.body(edge * way + rise) for edge in _LEAF)
    unit = view.body.pixels(1.0)
    shadow = np.concatenate([(inner + outer) / 2, outer[::-1]]) + np.asarray((0.010 * side * unit, 0.050 * unit))
    canvas.fill(shadow, _CLOTH_DARK)
    for share in (0.0, 0.06, 0.13, 0.22):
        edge = outer + (inner - outer) * share
        canvas.fill(np.concatenate([inner, edge[::-1]]), mixed(_COLLAR_SHADE, palette.COLLAR, 0.3 + share / 0.22 * 0.7))
    canvas.fill(ribbon(view.body(_FOLD * way + rise), view.body.pixels(0.008)), _COLLAR_SHADE)
