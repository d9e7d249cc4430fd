"""The visitor: a simpler figure than the avatar, whose limbs keep their shape."""

from typing import Final, Literal, cast

import numpy as np

from openrois_avatar.engines.animation.pose import Arm, Pose, channels, from_channels
from openrois_avatar.engines.figure.baked import read
from openrois_avatar.engines.figure.mesh import Mesh
from openrois_avatar.engines.figure.rig import (
    AT_ORIGIN,
    SHOULDER,
    Frame,
    Leg,
    body_frame,
    head_frame,
    leg_frames,
    standing,
    turned,
)
from openrois_avatar.engines.room.scene import OtherFigure
from openrois_avatar.engines.room.shot import METRE

Limb = Literal["trunk", "head", "hips", "arm_left", "arm_right"] | Leg
_REST: Final = channels(Pose())
_ARM: Final = 2.6
"""Length of an arm in dm: what its wrist's way is measured by."""


def build() -> dict[Limb, Mesh]:
    """Every limb in its own space, which is body space while the visitor stands.

    Raises:
        BakedError: the figure cannot be read.
    """
    return {cast("Limb", piece.space): piece.mesh() for piece in read("visitor")}


def frames(other: OtherFigure) -> dict[Limb, Frame]:
    """Return the frame of every limb in the world."""
    pose = from_channels({name: value + other.steps.get(name, 0.0) for name, value in _REST.items()})
    lower, rise = leg_frames(pose.left_leg, pose.right_leg)
    place = other.place
    world = standing(place.x * METRE, place.y * METRE, place.th).raised(rise)
    trunk = body_frame(pose)
    placed: dict[Limb, Frame] = {
        "trunk": trunk,
        "head": head_frame(pose),
        "hips": AT_ORIGIN,
        "arm_left": _swung(pose.left, 1).within(trunk),
        "arm_right": _swung(pose.right, -1).within(trunk),
    }
    for leg, frame in lower.items():
        placed[leg] = frame
    return {limb: frame.within(world) for limb, frame in placed.items()}


def _swung(arm: Arm, side: int) -> Frame:
    """A straight arm, so far ahead as the wrist of one that bends."""
    rotation = turned(0.0, (Arm().y - arm.y) / _ARM, 0.0)
    shoulder = np.asarray(SHOULDER) * (side, 1.0, 1.0)
    return Frame(rotation, shoulder - rotation @ shoulder)
