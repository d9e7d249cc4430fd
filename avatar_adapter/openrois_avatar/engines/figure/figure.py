"""The whole avatar: its parts, and where they are for a pose."""

from collections.abc import Callable, Collection, Mapping
from typing import Final, cast

import numpy as np

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure import arms, eyes, hands, head, mouth, trunk
from openrois_avatar.engines.figure.baked import Arrays, Piece, read, unreadable
from openrois_avatar.engines.figure.part import Motion, Part, still
from openrois_avatar.engines.figure.rig import AT_ORIGIN, Frame, Space, body_frame, head_frame, leg_frames
from openrois_avatar.engines.figure.shading import FINISHES, Surface

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
"""The spaces that only a view of the whole figure shows."""
SPACES: Final[tuple[Space, ...]] = ("hand_left", "hand_right", "head", "body", *_LOWER)
"""Every space, nearest to the viewer first."""
_MIRROR = np.diag((-1.0, 1.0, 1.0))
_MOTIONS: Final[Mapping[str, Callable[[int, Arrays], Motion]]] = {
    "still": lambda side, of: still(side, of["vertices"], of["normals"]),
    "brow": lambda side, of: eyes.brow_motion(side, of["depth"]),
    "catch-lights": lambda side, of: eyes.glints_motion(side),
    "cavity": lambda side, of: mouth.cavity_motion(of["rest"], of["jaw"]),
    "eyeball": lambda side, of: eyes.eyeball_motion(side, of["directions"]),
    "hand": lambda side, of: hands.hand_motion(side, of["vertices"], of["normals"], of["shares"]),
    "jumper": lambda side, of: trunk.jumper_motion(of["vertices"], of["normals"], of["swell"], of["lifted"]),
    "lashes": lambda side, of: eyes.lashes_motion(side),
    "lid": lambda side, of: eyes.lid_motion(side, of["depth"], of["skin_normals"]),
    "lips": lambda side, of: mouth.lips_motion(of["rest"], of["jaw"], of["skin_normals"]),
    "lower teeth": lambda side, of: mouth.lower_teeth_motion(of["vertices"], of["normals"]),
    "neck": lambda side, of: trunk.neck_motion(of["vertices"], of["normals"], of["share"]),
    "skull": lambda side, of: head.skull_motion(of["vertices"], of["normals"], of["share"]),
    "sleeve": lambda side, of: arms.sleeve_motion(side),
    "tongue": lambda side, of: mouth.tongue_motion(of["vertices"], of["normals"]),
    "upper teeth": lambda side, of: mouth.upper_teeth_motion(of["vertices"], of["normals"]),
}
"""Makers of the motion of a baked piece, by the name of the motion: of a side, with the piece's arrays."""


def build() -> list[Part]:
    """Every part of the baked figure. What is likely to be in front comes first.

    Raises:
        BakedError: the figure cannot be read.
    """
    pieces = read("avatar")
    try:
        return [part_of(piece) for piece in pieces]
    except KeyError as error:
        raise unreadable("avatar", error) from error


def part_of(piece: Piece) -> Part:
    """Return a piece of the baked figure as a part that follows the pose."""
    of = piece.arrays
    surface = Surface(of["albedo"], of["openness"], FINISHES[piece.finish], of["gloss"])
    motion = _MOTIONS[piece.motion](piece.side, of)
    return Part(piece.name, cast("Space", piece.space), of["faces"], surface, motion.shape, motion.state)


def visible(pose: Pose, whole: bool = False) -> dict[Space, bool]:
    """Which spaces may be in the picture: unless it shows the whole figure, hands that hang down are under it."""
    raised = {"hand_left": arms.raised(pose.left), "hand_right": arms.raised(pose.right)}
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
