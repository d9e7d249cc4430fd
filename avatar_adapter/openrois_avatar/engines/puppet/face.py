"""The face: its outline, ears, nose and blush, around eyes and mouth."""

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.puppet import eyes, mouth
from openrois_avatar.engines.puppet.canvas import Canvas, colour, mixed, spot
from openrois_avatar.engines.puppet.curves import Array, ellipse, mirrored, ribbon, ring, spline
from openrois_avatar.engines.puppet.view import View

_SKIN = colour(palette.SKIN)
_EDGE = mixed(palette.SKIN, palette.BLUSH, 0.26)
_SHADE = mixed(palette.SKIN, palette.LID_SHADE, 0.62)

# Every point is (x, depth, z) in head space.
_HALF = (
    (0.0, -0.40, 1.12),
    (0.48, -0.25, 1.00),
    (0.74, -0.10, 0.60),
    (0.80, -0.05, 0.15),
    (0.785, -0.10, -0.20),
    (0.70, -0.22, -0.52),
    (0.50, -0.38, -0.80),
    (0.24, -0.50, -0.97),
)
_CHIN = (0.0, -0.54, -1.015)
_OUTLINE = ring((*_HALF, _CHIN, *mirrored(_HALF[1:])), steps=4)
_FRINGE_SHADOW = spline(
    ((-0.44, -0.6, 1.0), (-0.08, -0.78, 0.74), (0.28, -0.8, 0.50), (0.56, -0.62, 0.17), (0.72, -0.4, -0.15))
)
_NOSE = spline(
    (
        (-0.095, -0.84, -0.315),
        (-0.075, -0.86, -0.372),
        (-0.03, -0.92, -0.385),
        (0.0, -0.93, -0.398),
        (0.03, -0.92, -0.385),
        (0.075, -0.86, -0.372),
        (0.095, -0.84, -0.315),
    )
)
_BRIDGE = spline(((0.085, -0.78, 0.06), (0.055, -0.84, -0.06), (0.07, -0.90, -0.24)))
_JAW_DROP = 0.13


class Face:
    """The face, with its soft spots prepared for so many pixels per decimetre."""

    def __init__(self, scale: float) -> None:
        self._blush = spot((0.30 * scale, 0.20 * scale), colour(palette.BLUSH), 0.42)
        self._nose_tip = spot((0.10 * scale, 0.08 * scale), colour(palette.BLUSH), 0.28)
        self._gleam = spot((0.055 * scale, 0.07 * scale), (255, 255, 255), 0.55)
        self._under_lip = spot((0.16 * scale, 0.06 * scale), _SHADE, 0.40)

    def draw(self, canvas: Canvas, view: View, pose: Pose) -> None:
        """The face, without the hair that falls over it."""
        self._draw_skin(canvas, view, pose)
        for side in (-1, 1):
            eyes.draw(canvas, view, pose, side)
        self._draw_nose(canvas, view)
        mouth.draw(canvas, view.head, pose.mouth)

    def _draw_skin(self, canvas: Canvas, view: View, pose: Pose) -> None:
        draw_ear(canvas, view, 1, pose.head_yaw)
        outline = view.round(_dropped(_OUTLINE, pose.mouth.jaw))
        focus = view.round(((0.0, -0.35, -0.08),))
        canvas.shade(outline, focus, _EDGE, _SKIN, steps=6, reach=0.42)
        fringe = view.round(_FRINGE_SHADOW)
        canvas.fill(
            ribbon(fringe, view.round.pixels(0.10) * np.sin(np.linspace(0.4, np.pi, len(fringe)))),
            mixed(palette.SKIN, _SHADE, 0.5),
        )
        for x in (-0.47, 0.47):
            canvas.stamp(self._blush, view.head(((x, -0.66, -0.36),))[0])
        canvas.stamp(self._under_lip, view.head(((0.0, -0.78, -0.80 - _JAW_DROP * pose.mouth.jaw),))[0])

    def _draw_nose(self, canvas: Canvas, view: View) -> None:
        bridge, tip = view.head(_BRIDGE), view.head(_NOSE)
        thin = np.sin(np.linspace(0, np.pi, len(bridge))) * view.head.pixels(0.014)
        canvas.fill(ribbon(bridge, thin), mixed(palette.SKIN, _SHADE, 0.35))
        canvas.stamp(self._nose_tip, view.head(((0.0, -0.94, -0.33),))[0])
        canvas.fill(ribbon(tip, np.sin(np.linspace(0, np.pi, len(tip))) * view.head.pixels(0.018)), _SHADE)
        canvas.stamp(self._gleam, view.head(((-0.015, -0.97, -0.27),))[0])


def _dropped(outline: Array, jaw: float) -> Array:
    """The outline with the chin lowered by an open jaw."""
    moved = outline.copy()
    moved[:, 2] -= _JAW_DROP * jaw * np.clip((-0.45 - outline[:, 2]) / 0.45, 0, 1)
    return moved


def draw_ear(canvas: Canvas, view: View, side: int, yaw: float) -> None:
    """An ear with its pearl; it gets narrow when the head turns it away."""
    width = 0.10 * min(max(1.0 - side * yaw * 2.2, 0.0), 1.2)
    ear = view.round(ellipse((side * 0.84, 0.02, -0.13), (width, 0.19)))
    canvas.fill(ear, mixed(palette.SKIN, _SHADE, 0.9))
    canvas.shade(
        ear - np.asarray((view.round.pixels(0.012) * side, 0.0)),
        ear.mean(axis=0),
        _EDGE,
        mixed(palette.SKIN, _SHADE, 0.5),
        steps=4,
        reach=0.6,
    )
    pearl = view.round(((side * 0.84, -0.03, -0.385),))[0]
    radius = view.round.pixels(0.062)
    canvas.disc(pearl, radius, mixed(palette.PEARL, palette.LID_SHADE, 0.45))
    canvas.disc(pearl - radius * 0.08, radius * 0.84, colour(palette.PEARL))
    canvas.disc(pearl - radius * 0.32, radius * 0.3, (255, 255, 255))
