"""The visitor as meshes: a simpler figure than the avatar, who is seen from farther away."""

from typing import Final, Literal

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Arm, Pose, channels, from_channels
from openrois_avatar.engines.room.scene import Somebody
from openrois_avatar.engines.room.shot import METRE
from openrois_avatar.engines.sculpt import legs
from openrois_avatar.engines.sculpt.body import SHOULDER
from openrois_avatar.engines.sculpt.distance import Array, Triple, cone, ellipsoid, join, mirrored
from openrois_avatar.engines.sculpt.hair import cap_field
from openrois_avatar.engines.sculpt.mesh import Mesh, merged
from openrois_avatar.engines.sculpt.part import mirrored_mesh
from openrois_avatar.engines.sculpt.rig import (
    AT_ORIGIN,
    Frame,
    Leg,
    body_frame,
    head_frame,
    leg_frames,
    standing,
    turned,
)

Limb = Literal["trunk", "head", "hips", "arm_left", "arm_right"] | Leg
_REST: Final = channels(Pose())
_WRIST: Final = (1.34, 0.16, -4.30)
_WAIST: Final = ((0.0, 0.33, -4.35), (0.98, 0.62, 1.05))
_ARM: Final = 2.6
"""Length of an arm in dm: what its wrist's way is measured by."""


def build() -> dict[Limb, Mesh]:
    """Every limb in its own space, which is body space while the visitor stands."""
    lower = legs.meshes(palette.VISITOR_TROUSERS, palette.WOOD_DARK)
    arm = merged([_sleeve(), _hand()])
    return {
        "trunk": legs.sculpted(_trunk_field, (-1.6, -0.8, -5.5), (1.6, 1.3, -1.1), 0.20, palette.VISITOR_JACKET),
        "head": _head(),
        "hips": lower["hips"],
        "arm_left": arm,
        "arm_right": mirrored_mesh(arm),
        "thigh_left": lower["thigh"],
        "thigh_right": mirrored_mesh(lower["thigh"]),
        "shin_left": lower["shin"],
        "shin_right": mirrored_mesh(lower["shin"]),
        "foot_left": lower["foot"],
        "foot_right": mirrored_mesh(lower["foot"]),
    }


def frames(somebody: Somebody) -> dict[Limb, Frame]:
    """Where every limb is in the world."""
    pose = from_channels({name: value + somebody.steps.get(name, 0.0) for name, value in _REST.items()})
    lower, rise = leg_frames(pose.left_leg, pose.right_leg)
    place = somebody.place
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


def _trunk_field(points: Array) -> Array:
    """A jacket from the neck to its hem."""
    p = mirrored(points)
    trunk = join(ellipsoid(p, (0.0, 0.32, -3.00), (1.02, 0.58, 1.45)), ellipsoid(p, *_WAIST), 0.35)
    trunk = join(trunk, cone(p, (0.20, 0.30, -1.80), (1.02, 0.31, -1.90), 0.34, 0.30), 0.45)
    trunk = join(trunk, cone(p, (0.10, 0.34, -1.30), (0.84, 0.36, -1.72), 0.30, 0.24), 0.35)
    return np.maximum(trunk - 0.05, -5.05 - points[:, 2])


def _sleeve() -> Mesh:
    return legs.sculpted(
        lambda points: cone(points, SHOULDER, _WRIST, 0.33, 0.22),
        (0.6, -0.3, -4.8), (1.8, 0.8, -1.4), 0.2, palette.VISITOR_JACKET,
    )  # fmt: skip


def _hand() -> Mesh:
    return legs.sculpted(
        lambda points: ellipsoid(points, (1.36, 0.10, -4.75), (0.16, 0.22, 0.42)),
        (1.0, -0.3, -5.4), (1.7, 0.5, -4.2), 0.15, palette.VISITOR_SKIN,
    )  # fmt: skip


def _head() -> Mesh:
    def skull(points: Array) -> Array:
        head = join(
            ellipsoid(points, (0.0, 0.08, 0.12), (0.80, 0.88, 1.0)),
            ellipsoid(points, (0.0, -0.10, -0.52), (0.56, 0.60, 0.50)),
            0.3,
        )
        nose = cone(points, (0.0, -0.78, 0.02), (0.0, -0.92, -0.28), 0.07, 0.10)
        return join(join(head, nose, 0.1), cone(points, (0, 0.15, -0.5), (0, 0.28, -1.8), 0.36, 0.38), 0.2)

    skin = legs.sculpted(skull, (-1.0, -1.2, -1.9), (1.0, 1.2, 1.3), 0.16, palette.VISITOR_SKIN)
    hair = legs.sculpted(cap_field, (-1.1, -1.0, -1.1), (1.1, 1.3, 1.5), 0.18, palette.VISITOR_HAIR)
    eyes = [_spot((x, -0.70, 0.06), (0.10, 0.12, 0.10), palette.LASH) for x in (-0.32, 0.32)]
    return merged([skin, hair, *eyes, _spot((0.0, -0.66, -0.52), (0.20, 0.06, 0.05), palette.LID_SHADE)])


def _spot(centre: Triple, radii: Triple, colour: str) -> Mesh:
    def ball(points: Array) -> Array:
        return ellipsoid(points, centre, radii)

    reach = np.asarray(radii) + 0.08
    return legs.sculpted(ball, np.asarray(centre) - reach, np.asarray(centre) + reach, 0.05, colour)
