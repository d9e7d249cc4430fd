"""Hands, flat as they are before their fingers bend, and the watch on the left wrist."""

import numpy as np
from openrois_avatar.engines import palette
from openrois_avatar.engines.figure.baked import Piece
from openrois_avatar.engines.figure.hands import FINGERS, THUMB
from openrois_avatar.engines.figure.mesh import Array, Mesh

from tools.sculpt import paint
from tools.sculpt.distance import cone, ellipsoid, join, occlusion
from tools.sculpt.mesh import polygonised
from tools.sculpt.pieces import piece, plain, sided, still

_FAN = 1.20
"""How much farther apart the tips are than the knuckles."""


def pieces() -> list[Piece]:
    """Both hands, each in its own space, and the watch."""
    return [*_hands(), *_watch()]


def hand_field(points: Array) -> Array:
    """The right hand, flat: wrist at the origin, fingers along z, palm towards -y, thumb towards +x."""
    hand = ellipsoid(points, (0.0, 0.0, 0.42), (0.315, 0.125, 0.40))
    hand = join(hand, cone(points, (0, 0, -0.25), (0, 0, 0.20), 0.165, 0.17), 0.15)
    fingers = np.full(len(points), np.inf)
    for across, length, radius, knuckle in FINGERS:
        end = (across * _FAN, -0.01, knuckle + length)
        finger = cone(points, (across, 0.0, knuckle - 0.15), end, radius, radius * 0.82)
        # Neighbours do not flow into each other: there is air between two fingers.
        fingers = np.minimum(fingers, finger)
    hand = join(hand, fingers, 0.045)
    thumb = join(cone(points, THUMB[0], THUMB[1], 0.10, 0.085), cone(points, THUMB[1], THUMB[2], 0.085, 0.068), 0.04)
    return join(hand, thumb, 0.09)


def _hands() -> list[Piece]:
    points, normals, faces = polygonised(hand_field, (-0.48, -0.32, -0.30), (0.62, 0.26, 1.42), 0.034)
    openness = paint.veil(occlusion(hand_field, points, normals, 0.25))
    return [
        piece(
            "hand", space, "hand", "skin", sided(faces, -side), paint.hand(points), openness, 0.05, side,
            vertices=points, normals=normals, shares=_bound(points),
        )
        for space, side in (("hand_left", 1), ("hand_right", -1))
    ]  # fmt: skip


def _bound(points: Array) -> Array:
    """Weights (n, 5) of little, ring, middle, index finger and thumb; what is left over belongs to the palm."""
    columns = []
    for across, length, _, knuckle in FINGERS:
        beside = np.abs(points[:, 0] - across * (1 + (_FAN - 1) * (points[:, 2] - knuckle) / length)) / 0.145
        columns.append(np.clip(1.5 - beside * 2, 0, 1) * np.clip((points[:, 2] - knuckle + 0.06) / 0.16, 0, 1))
    fingers = np.stack(columns, axis=1)
    fingers /= np.maximum(fingers.sum(axis=1, keepdims=True), 1.0)
    root = np.asarray(THUMB[0])
    axis = np.asarray(THUMB[2]) - root
    along = np.clip((points - root) @ axis / (axis @ axis), 0, 1)
    off = np.linalg.norm(points - root - along[:, None] * axis, axis=1)
    thumb = np.clip((0.16 - off) / 0.06, 0, 1) * np.clip((points[:, 0] - 0.20) / 0.10, 0, 1) * (points[:, 2] < 0.80)
    return np.concatenate([fingers * (1 - thumb[:, None]), thumb[:, None]], axis=1)


def _watch() -> list[Piece]:
    def strap(points: Array) -> Array:
        ring = np.sqrt((points[:, 0] / 1.05) ** 2 + (points[:, 1] / 0.98) ** 2) - 0.185
        return np.maximum(np.abs(ring) - 0.022, np.abs(points[:, 2] - 0.02) - 0.055)

    def dial(points: Array) -> Array:
        flat = np.sqrt(points[:, 0] ** 2 + (points[:, 2] - 0.02) ** 2) - 0.115
        return np.maximum(flat, np.abs(points[:, 1] - 0.215) - 0.025)

    made = []
    for field, colour, gloss in ((strap, palette.WATCH, 0.1), (dial, palette.WATCH_FACE, 0.4)):
        points, normals, faces = polygonised(field, (-0.26, -0.26, -0.14), (0.26, 0.30, 0.18), 0.032)
        mesh = Mesh(points, normals, faces, plain(colour, len(points)), np.ones(len(points)))
        made.append(still("watch", "hand_left", "cloth", mesh, gloss, side=-1))
    return made
