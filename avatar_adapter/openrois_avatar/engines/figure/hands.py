"""The motion of hands, which bend at their fingers."""

import numpy as np

from openrois_avatar.engines.animation.pose import Arm, Pose
from openrois_avatar.engines.figure.mesh import Array
from openrois_avatar.engines.figure.part import Motion, Shape, State, mirrored_shape, stepped

FINGERS = (
    # across, length, radius, knuckle: from the little finger to the index finger
    (-0.232, 0.36, 0.062, 0.66),
    (-0.079, 0.47, 0.067, 0.72),
    (0.077, 0.51, 0.069, 0.74),
    (0.230, 0.45, 0.067, 0.71),
)
THUMB = ((0.16, -0.05, 0.20), (0.37, -0.10, 0.46), (0.45, -0.13, 0.69))
"""The joints of the thumb and its tip."""


def hand_motion(side: int, vertices: Array, normals: Array, shares: Array) -> Motion:
    """Return the motion of a hand: vertices of the right one follow the fingers by their shares; the left mirrors it.

    Args:
        side: +1 is the avatar's left.
        vertices: of the right hand, flat, (n, 3).
        normals: (n, 3).
        shares: of little, ring, middle, index finger and thumb, (n, 5); what is left over belongs to the palm.
    """

    def arm(pose: Pose) -> Arm:
        return pose.left if side > 0 else pose.right

    def shape(pose: Pose) -> Shape:
        return mirrored_shape(_bent(Shape(vertices, normals), shares, arm(pose)), -side)

    def state(pose: Pose) -> State:
        return stepped(arm(pose).curl, arm(pose).spread)

    return Motion(shape, state)


def _bent(rest: Shape, shares: Array, arm: Arm) -> Shape:
    curl, spread = arm.curl, arm.spread
    points, normals = rest.vertices.copy(), rest.normals.copy()
    for number, (across, length, _, knuckle) in enumerate(FINGERS):
        share = shares[:, number]
        middle = knuckle + 0.55 * length
        for start, angle in ((middle, 1.25 * curl), (knuckle, 1.15 * curl)):
            beyond = share * np.clip((rest.vertices[:, 2] - start) / 0.07 + 0.5, 0, 1)
            _bend(points, normals, beyond, (across, 0.0, start), 0, -angle)
        _bend(points, normals, share, (across, 0.0, knuckle), 1, spread * 0.30 * (number - 1.6))
    _bend(points, normals, shares[:, 4], THUMB[0], 2, -0.55 * curl)
    _bend(points, normals, shares[:, 4], THUMB[0], 1, 0.35 * spread - 0.30 * curl)
    return Shape(points, normals)


def _bend(
    points: Array, normals: Array, share: Array, pivot: tuple[float, float, float], axis: int, angle: float
) -> None:
    """Rotate in place around the axis through the pivot, each vertex by its share of the angle."""
    moving = np.flatnonzero(share > 1e-3)
    turn = angle * share[moving]
    cos, sin = np.cos(turn), np.sin(turn)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    for vectors, origin in ((points, pivot), (normals, (0.0, 0.0, 0.0))):
        a, b = vectors[moving, u] - origin[u], vectors[moving, v] - origin[v]
        vectors[moving, u] = origin[u] + a * cos - b * sin
        vectors[moving, v] = origin[v] + a * sin + b * cos
