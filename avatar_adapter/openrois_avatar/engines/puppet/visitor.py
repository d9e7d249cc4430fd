"""The visitor, drawn with few strokes."""

from typing import Final

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Pose, channels, from_channels
from openrois_avatar.engines.figure.arms import chain
from openrois_avatar.engines.puppet import legs
from openrois_avatar.engines.puppet.canvas import Canvas, colour, mixed
from openrois_avatar.engines.puppet.curves import ellipse, mirrored, spline
from openrois_avatar.engines.puppet.view import Lens, View
from openrois_avatar.engines.room.scene import OtherFigure

_REST: Final = channels(Pose())
_SIDE = spline(
    (
        (0.32, 0.2, -1.25),
        (0.70, 0.2, -1.48),
        (1.22, 0.2, -1.78),
        (1.20, 0.1, -2.40),
        (1.03, 0.1, -3.60),
        (1.02, 0.1, -4.80),
        (0.94, 0.1, -5.05),
    ),
    4,
)
_TORSO = np.concatenate([_SIDE, mirrored(_SIDE)])
_JACKET = colour(palette.VISITOR_JACKET)
_EDGE = mixed(palette.VISITOR_JACKET, palette.LASH, 0.28)
_SKIN = colour(palette.VISITOR_SKIN)
_HAIR = colour(palette.VISITOR_HAIR)


def draw(canvas: Canvas, lens: Lens, other: OtherFigure) -> None:
    """The visitor where it is."""
    pose = from_channels({name: value + other.steps.get(name, 0.0) for name, value in _REST.items()})
    view = View.of(pose, lens, other.place)
    legs.draw(canvas, view, palette.VISITOR_TROUSERS, palette.WOOD_DARK)
    for side in (1, -1):
        _draw_arm(canvas, view, pose, side)
    neck = view.body(((0.0, 0.2, -0.9), (0.0, 0.2, -1.5)))
    canvas.limb(neck[0], view.body.pixels(0.36), neck[1], view.body.pixels(0.40), _SKIN)
    torso = view.body(_TORSO)
    canvas.shade(torso, torso.mean(axis=0), _EDGE, _JACKET, steps=7, reach=0.35)
    _draw_head(canvas, view)


def _draw_arm(canvas: Canvas, view: View, pose: Pose, side: int) -> None:
    bones = chain(pose, side)
    way = np.asarray((-side, 1.0, 1.0))
    shoulder, elbow, wrist = view.body(np.stack([bones.shoulder, bones.elbow, bones.wrist]) * way)
    hand = view.body((bones.wrist + bones.hand[:, 2] * 0.45)[None] * way)[0]
    unit = view.body.pixels(1.0)
    canvas.limb(wrist, 0.17 * unit, hand, 0.17 * unit, _SKIN)
    canvas.limb(shoulder, 0.33 * unit, elbow, 0.27 * unit, _EDGE)
    canvas.limb(elbow, 0.27 * unit, wrist, 0.21 * unit, _EDGE)


def _draw_head(canvas: Canvas, view: View) -> None:
    canvas.fill(view.round(ellipse((0.0, 0.15, 0.24), (0.92, 1.0))), _HAIR)
    if view.from_behind:
        return
    face = view.head(ellipse((0.0, -0.35, -0.12), (0.74, 0.88)))
    canvas.shade(face, face.mean(axis=0), mixed(palette.VISITOR_SKIN, palette.LASH, 0.12), _SKIN, steps=3, reach=0.3)
    unit = view.head.pixels(1.0, ((0.0, -0.8, 0.0),))
    for x in (-0.30, 0.30):
        canvas.disc(view.head(((x, -0.72, 0.0),))[0], 0.085 * unit, colour(palette.LASH))
    mouth = view.head(ellipse((0.0, -0.74, -0.50), (0.20, 0.045)))
    canvas.fill(mouth, colour(palette.LID_SHADE))
