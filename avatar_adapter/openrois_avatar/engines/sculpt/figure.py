"""The whole avatar: its parts, and where they are for a pose."""

from collections.abc import Collection
from typing import Final

import numpy as np

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.sculpt import arms, body, eyes, face, hands, legs
from openrois_avatar.engines.sculpt.hair import Hair
from openrois_avatar.engines.sculpt.head import DepthMap
from openrois_avatar.engines.sculpt.part import Part
from openrois_avatar.engines.sculpt.rig import AT_ORIGIN, Frame, Space, body_frame, head_frame, leg_frames

_LOWER: Final[tuple[Space, ...]] = (
    "back",
    "hips",
    "thigh_left",
    "thigh_right",
    "shin_left",
    "shin_right",
    "foot_left",
    "foot_right",
)
"""What only a view of the whole figure shows."""
SPACES: Final[tuple[Space, ...]] = ("hand_left", "hand_right", "head", "body", *_LOWER)
"""Every space, nearest to the viewer first."""
_MIRROR = np.diag((-1.0, 1.0, 1.0))


def build() -> list[Part]:
    """Sculpt every part; takes about half a second. What is likely to be in front comes first."""
    depth, hair = DepthMap(), Hair()
    return [
        *hands.parts(),
        hair.part(),
        *eyes.parts(depth),
        *face.parts(depth, hair.shadow),
        *arms.parts(),
        *body.parts(),
        *legs.parts(),
    ]


def visible(pose: Pose, whole: bool = False) -> dict[Space, bool]:
    """Which spaces may be in the picture: unless it shows the whole figure, hands that hang down are under it."""
    raised = {"hand_left": hands.raised(pose.left), "hand_right": hands.raised(pose.right)}
    return {space: whole or space in ("body", "head") or raised.get(space, False) for space in SPACES}


def frames(pose: Pose, world: Frame = AT_ORIGIN, spaces: Collection[Space] = SPACES) -> dict[Space, Frame]:
    """The place of each of these spaces in the world, for a figure that stands at `world`."""
    lower, rise = leg_frames(pose.left_leg, pose.right_leg)
    world = world.raised(rise)
    placed = _upper(pose)
    for leg, frame in lower.items():
        placed[leg] = frame
    return {space: placed[space].within(world) for space in spaces}


def _upper(pose: Pose) -> dict[Space, Frame]:
    """All but the legs, in body space."""
    whole = body_frame(pose)
    right, left = arms.chain(pose, -1), arms.chain(pose, 1)
    return {
        "body": whole,
        "back": whole,
        "hips": AT_ORIGIN,
        "head": head_frame(pose),
        "hand_right": Frame(right.hand, right.wrist).within(whole),
        # The left arm is solved as a right one: mirrored into place, and its meshes are mirrored back.
        "hand_left": Frame(_MIRROR @ left.hand @ _MIRROR, left.wrist * (-1, 1, 1)).within(whole),
    }
