"""Hands that bend at their fingers, and the watch on the left wrist."""

import numpy as np

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Arm, Pose
from openrois_avatar.engines.sculpt import paint
from openrois_avatar.engines.sculpt.distance import Array, cone, ellipsoid, join, occlusion
from openrois_avatar.engines.sculpt.mesh import Mesh, polygonised
from openrois_avatar.engines.sculpt.part import Part, Shape, mirrored_mesh, mirrored_shape, sided, stepped, still
from openrois_avatar.engines.sculpt.rig import Space
from openrois_avatar.engines.sculpt.shading import CLOTH, SKIN, Surface, linear

_FINGERS = (
    # across, length, radius, knuckle: from the little finger to the index finger
    (-0.232, 0.36, 0.062, 0.66),
    (-0.079, 0.47, 0.067, 0.72),
    (0.077, 0.51, 0.069, 0.74),
    (0.230, 0.45, 0.067, 0.71),
)
_FAN = 1.20
"""How much farther apart the tips are than the knuckles."""
_THUMB = ((0.16, -0.05, 0.20), (0.37, -0.10, 0.46), (0.45, -0.13, 0.69))
_OUT_OF_SIGHT = -3.75
"""A wrist below this height (dm) is under the picture."""


def parts() -> list[Part]:
    """Both hands, each in its own space, and the watch."""
    hand = _Hand()
    return [*(hand.part(side) for side in (1, -1)), *_watch()]


def raised(arm: Arm) -> bool:
    """Whether any of the hand may be in the picture."""
    return arm.z > _OUT_OF_SIGHT


def hand_field(points: Array) -> Array:
    """The right hand, flat: wrist at the origin, fingers along z, palm towards -y, thumb towards +x."""
    hand = ellipsoid(points, (0.0, 0.0, 0.42), (0.315, 0.125, 0.40))
    hand = join(hand, cone(points, (0, 0, -0.25), (0, 0, 0.20), 0.165, 0.17), 0.15)
    fingers = np.full(len(points), np.inf)
    for across, length, radius, knuckle in _FINGERS:
        end = (across * _FAN, -0.01, knuckle + length)
        finger = cone(points, (across, 0.0, knuckle - 0.15), end, radius, radius * 0.82)
        # Neighbours do not flow into each other: there is air between two fingers.
        fingers = np.minimum(fingers, finger)
    hand = join(hand, fingers, 0.045)
    thumb = join(
        cone(points, _THUMB[0], _THUMB[1], 0.10, 0.085), cone(points, _THUMB[1], _THUMB[2], 0.085, 0.068), 0.04
    )
    return join(hand, thumb, 0.09)


class _Hand:
    """The right hand's mesh and how each vertex follows the finger bones; the left one mirrors it."""

    def __init__(self) -> None:
        self._rest, self._normals, self._faces = polygonised(
            hand_field, (-0.48, -0.32, -0.30), (0.62, 0.26, 1.42), 0.034
        )
        self._albedo = paint.hand(self._rest)
        self._openness = paint.veil(occlusion(hand_field, self._rest, self._normals, 0.25))
        self._shares = _bound(self._rest)

    def part(self, side: int) -> Part:
        def arm(pose: Pose) -> Arm:
            return pose.left if side > 0 else pose.right

        def shape(pose: Pose) -> Shape:
            return mirrored_shape(self._bent(arm(pose).curl, arm(pose).spread), -side)

        space: Space = "hand_left" if side > 0 else "hand_right"
        surface = Surface(self._albedo, self._openness, SKIN, 0.05)
        faces = sided(self._faces, -side)
        return Part("hand", space, faces, surface, shape, lambda pose: stepped(arm(pose).curl, arm(pose).spread))

    def _bent(self, curl: float, spread: float) -> Shape:
        points, normals = self._rest.copy(), self._normals.copy()
        for number, (across, length, _, knuckle) in enumerate(_FINGERS):
            share = self._shares[:, number]
            middle = knuckle + 0.55 * length
            for start, angle in ((middle, 1.25 * curl), (knuckle, 1.15 * curl)):
                beyond = share * np.clip((self._rest[:, 2] - start) / 0.07 + 0.5, 0, 1)
                _bend(points, normals, beyond, (across, 0.0, start), 0, -angle)
            _bend(points, normals, share, (across, 0.0, knuckle), 1, spread * 0.30 * (number - 1.6))
        _bend(points, normals, self._shares[:, 4], _THUMB[0], 2, -0.55 * curl)
        _bend(points, normals, self._shares[:, 4], _THUMB[0], 1, 0.35 * spread - 0.30 * curl)
        return Shape(points, normals)


def _bound(points: Array) -> Array:
    """Weights (n, 5) of little, ring, middle, index finger and thumb; what is left over belongs to the palm."""
    columns = []
    for across, length, _, knuckle in _FINGERS:
        beside = np.abs(points[:, 0] - across * (1 + (_FAN - 1) * (points[:, 2] - knuckle) / length)) / 0.145
        columns.append(np.clip(1.5 - beside * 2, 0, 1) * np.clip((points[:, 2] - knuckle + 0.06) / 0.16, 0, 1))
    fingers = np.stack(columns, axis=1)
    fingers /= np.maximum(fingers.sum(axis=1, keepdims=True), 1.0)
    root = np.asarray(_THUMB[0])
    axis = np.asarray(_THUMB[2]) - root
    along = np.clip((points - root) @ axis / (axis @ axis), 0, 1)
    off = np.linalg.norm(points - root - along[:, None] * axis, axis=1)
    thumb = np.clip((0.16 - off) / 0.06, 0, 1) * np.clip((points[:, 0] - 0.20) / 0.10, 0, 1) * (points[:, 2] < 0.80)
    return np.concatenate([fingers * (1 - thumb[:, None]), thumb[:, None]], axis=1)


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


def _watch() -> list[Part]:
    def strap(points: Array) -> Array:
        ring = np.sqrt((points[:, 0] / 1.05) ** 2 + (points[:, 1] / 0.98) ** 2) - 0.185
        return np.maximum(np.abs(ring) - 0.022, np.abs(points[:, 2] - 0.02) - 0.055)

    def dial(points: Array) -> Array:
        flat = np.sqrt(points[:, 0] ** 2 + (points[:, 2] - 0.02) ** 2) - 0.115
        return np.maximum(flat, np.abs(points[:, 1] - 0.215) - 0.025)

    made = []
    for field, colour, gloss in ((strap, palette.WATCH, 0.1), (dial, palette.WATCH_FACE, 0.4)):
        points, normals, faces = polygonised(field, (-0.26, -0.26, -0.14), (0.26, 0.30, 0.18), 0.032)
        mesh = Mesh(points, normals, faces, np.tile(linear(colour), (len(points), 1)), np.ones(len(points)))
        made.append(still("watch", "hand_left", mirrored_mesh(mesh), CLOTH, gloss))
    return made
