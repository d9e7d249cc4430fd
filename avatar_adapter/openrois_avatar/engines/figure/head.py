"""The motion of the skin of the head: the relief of the face, and the turn of the jaw."""

from typing import Final

import numpy as np
import numpy.typing as npt

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure.mesh import Array, grid_normals, smooth
from openrois_avatar.engines.figure.part import Motion, Shape, stepped

EYE = (0.350, -0.545, -0.095)
"""Centre of the left eyeball; the right one mirrors it."""
EYE_RADIUS = 0.30
EYE_PATCH = (0.36, 0.27, 0.27)
"""Half widths outwards and inwards, and half height, of the skin around an eye that moves with the lids."""
MOUTH = (0.0, -0.83, -0.600)
"""Where the lips meet, on the surface."""
HINGE = (0.0, 0.12, -0.28)
"""The axis, parallel to x, around which the jaw opens."""
JAW_ANGLE = 0.23
"""Radians at a fully open jaw."""


class DepthMap:
    """The y of the face's surface as seen from the front: sampled when the figure is baked, interpolated here."""

    REACH: Final = 0.80
    """Of x to both sides of the middle; z goes from `LOW` to `HIGH`."""
    LOW: Final = -1.08
    HIGH: Final = 0.56
    STEP: Final = 0.02

    def __init__(self, depth: Array) -> None:
        self._depth = depth

    def __call__(self, x: Array, z: Array) -> Array:
        """The surface's y at (x, z), arrays of any equal shape; outside of the map its border counts."""
        rows, columns = self._depth.shape
        across = np.clip(np.abs(x) / self.STEP, 0, columns - 1.001)
        up = np.clip((z - self.LOW) / self.STEP, 0, rows - 1.001)
        i, j = up.astype(np.intp), across.astype(np.intp)
        u, v = up - i, across - j
        depth = self._depth
        near = depth[i, j] * (1 - v) + depth[i, j + 1] * v
        far = depth[i + 1, j] * (1 - v) + depth[i + 1, j + 1] * v
        return np.asarray(near * (1 - u) + far * u)


def jaw_turned(points: Array, share: Array, angle: float) -> Array:
    """The points after the jaw has opened by `angle` radians, each by its share."""
    turn = angle * share
    y, z = points[..., 1] - HINGE[1], points[..., 2] - HINGE[2]
    moved = points.copy()
    moved[..., 1] = HINGE[1] + y * np.cos(turn) - z * np.sin(turn)
    moved[..., 2] = HINGE[2] + y * np.sin(turn) + z * np.cos(turn)
    return moved


def patched(grid: Array, skin: Array, smoothed: npt.ArrayLike = 0.0) -> Array:
    """Normals of a patch of skin that become those of the face: under its last rings, and where it is `smoothed`."""
    normals = -grid_normals(grid, closed=True)
    border = smooth((np.arange(len(grid)) - len(grid) + 5) / 3)[:, None]
    share = np.maximum(border, smoothed)[:, :, None]
    normals = normals * (1 - share) + skin * share
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-9))


def skull_motion(vertices: Array, normals: Array, share: Array) -> Motion:
    """Return the motion of the skull's skin, whose vertices follow the jaw by their shares (n,)."""
    moving = np.flatnonzero(share > 1e-3)

    def shape(pose: Pose) -> Shape:
        moved = vertices.copy()
        moved[moving] = jaw_turned(moved[moving], share[moving], JAW_ANGLE * pose.mouth.jaw)
        return Shape(moved, normals)

    return Motion(shape, lambda pose: stepped(pose.mouth.jaw))
