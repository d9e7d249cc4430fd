"""The whole avatar: its parts, and where they are for a pose."""

from typing import Final

import numpy as np

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.sculpt import arms, body, eyes, face, hands
from openrois_avatar.engines.sculpt.hair import Hair
from openrois_avatar.engines.sculpt.head import DepthMap
from openrois_avatar.engines.sculpt.part import Part, Space
from openrois_avatar.engines.sculpt.rig import Frame, body_frame, head_frame

SPACES: Final[tuple[Space, ...]] = ("hand_left", "hand_right", "head", "body")
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
    ]


def visible(pose: Pose) -> dict[Space, bool]:
    """Which spaces may be in the picture: hands that hang down are under it."""
    return {"body": True, "head": True, "hand_left": hands.raised(pose.left), "hand_right": hands.raised(pose.right)}


def frames(pose: Pose) -> dict[Space, Frame]:
    """Every space's place in the world."""
    whole = body_frame(pose)
    right, left = arms.chain(pose, -1), arms.chain(pose, 1)
    return {
        "body": whole,
        "head": head_frame(pose),
        "hand_right": Frame(right.hand, right.wrist).within(whole),
        # The left arm is solved as a right one: mirrored into place, and its meshes are mirrored back.
        "hand_left": Frame(_MIRROR @ left.hand @ _MIRROR, left.wrist * (-1, 1, 1)).within(whole),
    }
