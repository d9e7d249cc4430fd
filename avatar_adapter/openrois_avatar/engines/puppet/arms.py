"""Arms: sleeves over the bones that the sculpted figure has, with hands and a watch."""

from typing import Final

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Arm, Pose
from openrois_avatar.engines.figure.arms import Chain, chain, raised
from openrois_avatar.engines.puppet.canvas import Canvas, colour, hull, mixed
from openrois_avatar.engines.puppet.curves import Array, ellipse
from openrois_avatar.engines.puppet.hands import draw_hand
from openrois_avatar.engines.puppet.view import View

_RADII: Final = (0.30, 0.245, 0.20)
"""Of the sleeve at shoulder, elbow and cuff, in dm."""
_EDGE, _MIDDLE = mixed(palette.JUMPER, palette.IRIS_DARK, 0.30), mixed(palette.JUMPER, palette.IRIS_BRIGHT, 0.08)
_TONES: Final = tuple((1 - 0.13 * step, mixed(_EDGE, _MIDDLE, step / 4)) for step in range(5))
"""Shares of the sleeve's width and their colours, from its edge to its middle."""
_POINTING: Final = -0.45
"""How far a unit of the hand comes towards the viewer when it points at them."""
_CUFF_END: Final = 0.93
"""Where the sleeve ends on the way from elbow to wrist."""


def draw_upper(canvas: Canvas, view: View, pose: Pose) -> None:
    """Both sleeves down to the elbow, which belong behind the jumper's shoulders."""
    for side in (1, -1):
        joints, radii = _sleeve(view, pose, side)
        for share, paint in _TONES:
            canvas.limb(joints[0], radii[0] * share, joints[1], radii[1] * share, paint)


def draw_lower(canvas: Canvas, view: View, pose: Pose, whole: bool = False) -> None:
    """Forearms and hands, in front of everything; the one whose wrist is nearer is in front of the other.

    Hands that hang down are drawn only if the `whole` figure is seen.
    """
    for side in sorted((1, -1), key=lambda side: -_arm(pose, side).y):
        joints, radii = _sleeve(view, pose, side)
        for share, paint in _TONES:
            canvas.limb(joints[1], radii[1] * share, joints[2], radii[2] * share, paint)
        if whole or raised(_arm(pose, side)):
            bones, way = chain(pose, side), np.asarray((-side, 1.0, 1.0))
            _draw_cuff(canvas, view, bones, way)
            # A hand that points at the viewer hides its wrist.
            hidden = float(bones.hand[1, 2]) < _POINTING
            if side > 0 and hidden:
                _draw_watch(canvas, view, bones, way)
            draw_hand(canvas, view.body, bones, _arm(pose, side), way)
            if side > 0 and not hidden:
                _draw_watch(canvas, view, bones, way)


def _arm(pose: Pose, side: int) -> Arm:
    return pose.left if side > 0 else pose.right


def _sleeve(view: View, pose: Pose, side: int) -> tuple[Array, list[float]]:
    """Shoulder, elbow and cuff in pixels, with the radii there."""
    bones = chain(pose, side)
    end = bones.elbow + (bones.wrist - bones.elbow) * _CUFF_END
    joints = np.stack([bones.shoulder, bones.elbow, end]) * (-side, 1.0, 1.0)
    return view.body(joints), [
        view.body.pixels(radius, joint[None]) for radius, joint in zip(_RADII, joints, strict=True)
    ]


def _draw_cuff(canvas: Canvas, view: View, bones: Chain, way: Array) -> None:
    around = ellipse((0.0, 0.0, 0.0), (0.205, 0.205))[:, [0, 2, 1]]
    forearm = (bones.wrist - bones.elbow) / np.linalg.norm(bones.wrist - bones.elbow)
    across = np.cross(forearm, bones.hand[:, 1])
    across /= np.linalg.norm(across)
    frame = np.stack([across, np.cross(across, forearm), forearm], axis=1)
    rings = [(bones.wrist + (around + np.asarray((0.0, 0.0, shift))) @ frame.T) * way for shift in (-0.16, -0.02)]
    canvas.fill(hull(view.body(np.concatenate(rings))), colour(palette.JUMPER_BAND))


def _draw_watch(canvas: Canvas, view: View, bones: Chain, way: Array) -> None:
    around = ellipse((0.0, 0.0, 0.0), (0.185, 0.175))[:, [0, 2, 1]]
    rings = [(bones.wrist + (around + np.asarray((0.0, 0.0, shift))) @ bones.hand.T) * way for shift in (0.0, 0.11)]
    canvas.fill(hull(view.body(np.concatenate(rings))), colour(palette.WATCH))
    back = bones.hand[:, 1]
    if back[1] > 0.25:
        return
    for radius, paint in ((0.125, colour(palette.WATCH)), (0.095, colour(palette.WATCH_FACE))):
        dial = ellipse((0.0, 0.20, 0.055), (radius, radius))
        canvas.fill(view.body((bones.wrist + dial @ bones.hand.T) * way), paint)
