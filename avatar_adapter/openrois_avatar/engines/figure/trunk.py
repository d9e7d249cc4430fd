"""The motion of neck and jumper: the neck goes along with the head, the chest breathes, and the shoulders rise."""

import numpy as np

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure.mesh import Array
from openrois_avatar.engines.figure.part import Motion, Shape, State, stepped
from openrois_avatar.engines.figure.rig import NECK, head_turn, shoulder_lift

_UP = np.asarray((0.0, 0.0, 1.0))


def jumper_motion(vertices: Array, normals: Array, swell: Array, lifted: Array) -> Motion:
    """Return the motion of the jumper, which follows breath and shoulders.

    Args:
        vertices: at rest, (n, 3).
        normals: (n, 3), in every pose.
        swell: the way of each vertex when the chest is full of air, (n, 3).
        lifted: how far each vertex follows the left and the right shoulder, (n, 2).
    """
    shares = {side: lifted[:, column, None] * _UP for column, side in enumerate((1, -1))}

    def shape(pose: Pose) -> Shape:
        moved = vertices + pose.breath * swell
        for side, share in shares.items():
            moved = moved + shoulder_lift(pose, side) * share
        return Shape(moved, normals)

    def state(pose: Pose) -> State:
        return stepped(pose.breath, pose.shoulder_left, pose.shoulder_right)

    return Motion(shape, state)


def neck_motion(vertices: Array, normals: Array, share: Array) -> Motion:
    """Return the motion of the neck's skin, whose vertices follow the head by their shares (n,)."""
    column = share[:, None]

    def shape(pose: Pose) -> Shape:
        turned = (vertices - NECK) @ head_turn(pose).T + NECK
        return Shape(vertices + (turned - vertices) * column, normals)

    def state(pose: Pose) -> State:
        return stepped(pose.head_yaw, pose.head_pitch, pose.head_roll)

    return Motion(shape, state)
