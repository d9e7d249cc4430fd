"""The skull, face and nose: one field, its depth from the front, and the room in it that is left for eyes and mouth."""

import numpy as np
import numpy.typing as npt
from openrois_avatar.engines.figure.head import EYE, EYE_PATCH, MOUTH, DepthMap
from openrois_avatar.engines.figure.mesh import Array, smooth

from tools.sculpt.distance import carve, cone, ellipsoid, gradient, join, march, mirrored

MOUTH_PATCH = (0.42, 0.20, 0.27)
"""Half width, height above and depth below the mouth of the skin that moves with the lips."""
EAR = (0.83, 0.02, -0.13)
"""Centre of the left ear."""
PEARL = (0.855, -0.045, -0.385)
"""Where the left earring hangs."""


def face_field(points: Array) -> Array:
    """The head without lips, eyes and ears."""
    p = mirrored(points)
    head = ellipsoid(p, (0, 0.12, 0.33), (0.84, 0.95, 0.90))
    head = join(head, ellipsoid(p, (0, -0.20, -0.16), (0.720, 0.61, 0.72)), 0.30)
    head = join(head, ellipsoid(p, (0.15, -0.36, -0.62), (0.24, 0.33, 0.22)), 0.36)
    head = join(head, ellipsoid(p, (0, -0.65, -0.835), (0.15, 0.14, 0.11)), 0.30)
    head = join(head, ellipsoid(p, (0.41, -0.51, -0.38), (0.27, 0.25, 0.23)), 0.26)
    head = join(head, ellipsoid(p, (0, -0.70, -0.56), (0.23, 0.14, 0.18)), 0.22)
    head = carve(head, ellipsoid(p, (0.37, -1.00, -0.07), (0.30, 0.185, 0.16)), 0.24)
    head = join(head, cone(p, (0, -0.78, 0.02), (0, -0.905, -0.29), 0.040, 0.048), 0.15)
    head = join(head, ellipsoid(p, (0, -0.930, -0.322), (0.068, 0.078, 0.062)), 0.08)
    return join(head, ellipsoid(p, (0.060, -0.875, -0.338), (0.042, 0.054, 0.038)), 0.06)


def ear_field(points: Array) -> Array:
    """The left ear: a shell with a rolled rim, a hollow and a lobe."""
    p = points - np.asarray(EAR)
    turn = 0.42
    x, y = p[:, 0] * np.cos(turn) - p[:, 1] * np.sin(turn), p[:, 0] * np.sin(turn) + p[:, 1] * np.cos(turn)
    q = np.stack([x, y - 0.18 * p[:, 2], p[:, 2]], axis=1)
    shell = ellipsoid(q, (0, 0, 0), (0.055, 0.155, 0.225))
    flat = np.stack(
        [q[:, 0], np.sqrt((q[:, 1] / 0.150) ** 2 + ((q[:, 2] - 0.01) / 0.215) ** 2) * 0.17 - 0.17, 0 * x], axis=1
    )
    rim = np.sqrt((flat[:, 0] - 0.025) ** 2 + flat[:, 1] ** 2) - 0.030
    shell = carve(shell, ellipsoid(q, (0.075, -0.01, 0.0), (0.075, 0.085, 0.13)), 0.05)
    ear = join(shell, np.maximum(rim, -(q[:, 2] + 0.12)), 0.035)
    return join(ear, ellipsoid(q, (0.012, -0.045, -0.185), (0.045, 0.062, 0.07)), 0.05)


def depth_of_face() -> Array:
    """The y of the face's surface as seen from the front, for `DepthMap`."""
    low, high, step = DepthMap.LOW, DepthMap.HIGH, DepthMap.STEP
    xs, zs = np.arange(0.0, DepthMap.REACH + step, step), np.arange(low, high + step, step)
    x, z = (part.ravel() for part in np.meshgrid(xs, zs))
    origins = np.stack([x, np.full_like(x, -1.2), z], axis=1)
    ahead = np.broadcast_to(np.asarray((0.0, 1.0, 0.0)), origins.shape)
    return np.asarray((march(face_field, origins, ahead, 1.6, steps=24) - 1.2).reshape(len(zs), len(xs)))


def normals_of_face(depth: DepthMap, x: Array, z: Array) -> Array:
    """Unit normals of the face at (x, z), shape (..., 3)."""
    points = np.stack([x, depth(x, z), z], axis=-1)
    return gradient(face_field, points.reshape(-1, 3), 0.01).reshape(points.shape)


def jaw_share(points: Array) -> Array:
    """Return the share of the jaw's motion for points of the skin: 0 above the lips, 1 at the chin, 0 at the neck."""
    below = smooth((MOUTH[2] + 0.03 - points[..., 2]) / 0.20)
    front = smooth((0.12 - points[..., 1]) / 0.55)
    return below * front


def in_patch(points: Array, margin: float) -> npt.NDArray[np.bool_]:
    """Tell which points of the skin lie in the eye and mouth patches, leaving `margin` (dm) of overlap."""
    x, z, front = np.abs(points[:, 0]) - EYE[0], points[:, 2], points[:, 1] < -0.25
    outwards, inwards, high = (extent - margin for extent in EYE_PATCH)
    eye = (x / np.where(x > 0, outwards, inwards)) ** 2 + ((z - EYE[2]) / high) ** 2
    # Wide lips come near the border of theirs.
    width, above, below = (extent - margin / 2 for extent in MOUTH_PATCH)
    mouth = (points[:, 0] / width) ** 2 + ((z - MOUTH[2]) / np.where(z > MOUTH[2], above, below)) ** 2
    return np.asarray(front & ((eye < 1) | (mouth < 1)))
