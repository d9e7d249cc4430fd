"""Neck, shoulders, jumper with its sleeves, and collar: fields and meshes in body space."""

from typing import Final

import numpy as np
from openrois_avatar.engines import palette
from openrois_avatar.engines.figure.arms import ALONG, RINGS, SECTION
from openrois_avatar.engines.figure.baked import Piece
from openrois_avatar.engines.figure.mesh import Array, Mesh, grid_faces, grid_normals, smooth, towards

from tools.sculpt import paint
from tools.sculpt.distance import carve, cone, ellipsoid, gradient, join, mirrored, occlusion
from tools.sculpt.mesh import compact, polygonised, without
from tools.sculpt.pieces import both_ways, piece, plain, still

_ANGLES, _AROUND = 48, 6
_NECK_HOLE = ((0.0, 0.16, -1.42), (0.575, 0.56, 0.40))
"""Centre and radii of the ellipsoid that cuts the jumper's neck opening."""
_NAPE: Final = 0.55
"""How far back the skin begins that only a view of the whole figure shows, in dm."""


def torso_field(points: Array) -> Array:
    """The body under the clothes, neck included."""
    p = mirrored(points)
    body = ellipsoid(p, (0, 0.32, -3.00), (1.02, 0.58, 1.45))
    body = join(body, cone(p, (0.20, 0.30, -1.80), (1.02, 0.31, -1.90), 0.32, 0.28), 0.45)
    body = join(body, cone(p, (0.10, 0.34, -1.25), (0.84, 0.36, -1.72), 0.24, 0.20), 0.35)
    body = join(body, ellipsoid(p, (0.40, -0.02, -2.90), (0.42, 0.32, 0.42)), 0.55)
    neck = cone(p, (0, 0.10, -0.55), (0, 0.26, -1.75), 0.345, 0.38)
    return join(body, neck, 0.30)


def neck_field(points: Array) -> Array:
    """The skin that shows between chin and neckline, with a hint of collarbones."""
    p = mirrored(points)
    skin = torso_field(points)
    return join(skin, cone(p, (0.06, -0.07, -1.78), (0.80, 0.10, -1.60), 0.045, 0.05), 0.10)


def jumper_field(points: Array) -> Array:
    """The jumper: a layer over the body with a round neck opening."""
    return carve(torso_field(points) - 0.045, neck_hole(points), 0.04)


def neck_hole(points: Array) -> Array:
    """The jumper's neck opening: behind, it ends where band and collar lie."""
    end = -1.19 - 1.4 * np.maximum(0.25 - points[:, 1], 0.0)
    return np.maximum(ellipsoid(points, *_NECK_HOLE), (end - points[:, 2]) * 0.6)


def neckline(turn: Array) -> Array:
    """Points (n, 3) on the jumper where its neck opening is; turn 0 is the front."""
    centre, radii = (np.asarray(part) for part in _NECK_HOLE)
    level = np.linspace(0.6, -1.1, 60)
    aside = np.stack([np.sin(turn), -np.cos(turn)], axis=1)
    scale = np.cos(level)[None, :, None] * radii[:2]
    points = np.empty((len(turn), len(level), 3))
    points[..., :2] = centre[:2] + aside[:, None] * scale
    points[..., 2] = centre[2] + np.sin(level) * radii[2]
    inside = torso_field(points.reshape(-1, 3)).reshape(len(turn), -1) < 0.045
    first = np.argmax(inside, axis=1)
    return np.asarray(points[np.arange(len(turn)), first])


def _onto_jumper(points: Array) -> Array:
    for _ in range(4):
        points = points - gradient(torso_field, points, 0.01) * (torso_field(points) - 0.05)[:, None]
    return points


def neckband() -> Array:
    """The ribbed band along the neck opening: a closed tube, grid (_AROUND + 1, _ANGLES, 3)."""
    turn = np.arange(_ANGLES) * 2 * np.pi / _ANGLES
    line = neckline(turn)
    for _ in range(3):
        line = (np.roll(line, 1, 0) + 2 * line + np.roll(line, -1, 0)) / 4
    outward = np.stack([np.sin(turn), -np.cos(turn), 0 * turn], axis=1)
    lift = np.asarray((0.0, 0.0, 1.0))
    rows = []
    for angle in np.linspace(0, 2 * np.pi, _AROUND + 1):
        rows.append(line + outward * np.cos(angle) * 0.035 + lift * (np.sin(angle) * 0.065 + 0.03))
    return np.stack(rows)


def collar(side: int) -> Array:
    """One rounded leaf of the shirt's collar lying on the jumper, (rows, columns, 3), from the throat to the nape."""
    along = np.linspace(0, 1, 28)
    turn = side * (0.045 + along * (np.pi - 0.045))
    inner = neckline(turn) + np.asarray((0, 0, 0.05))
    for _ in range(2):
        inner[1:-1] = (inner[:-2] + 2 * inner[1:-1] + inner[2:]) / 4
    width = 0.34 * np.sqrt(np.clip(1 - (1 - np.clip(along / 0.16, 0, 1)) ** 2, 0, 1)) * (1 - 0.55 * along**2)
    rows = [inner + np.asarray((0, 0, 0.03))]
    for share in (0.0, 0.15, 0.4, 0.7, 1.0):
        aside = np.stack([np.sin(turn), -np.cos(turn), 0 * turn], axis=1)
        flat = inner + aside * (width * share)[:, None] - np.asarray((0, 0, 0.25)) * (width * share)[:, None]
        above = gradient(torso_field, _onto_jumper(flat), 0.01)
        rows.append(_onto_jumper(flat) + above * (0.055 - 0.03 * share**3))
    return np.stack(rows)


def pieces() -> list[Piece]:
    """Sleeves, neck, nape, jumper, neckband and collar."""
    leaves = [_leaf(side) for side in (1, -1)]
    return [*(_sleeve(side) for side in (1, -1)), *_neck(), _jumper(), _band(), *leaves]


def _sleeve(side: int) -> Piece:
    openness = np.interp(ALONG, [-0.2, 0.25, 0.9, 1.83, 1.86, 1.97], [0.85, 0.88, 1.0, 1.0, 0.8, 0.95])
    # Seen from inside at the cuff.
    faces = both_ways(grid_faces(RINGS, SECTION, closed=True))
    albedo = plain(palette.JUMPER, RINGS * SECTION)
    return piece("sleeve", "body", "sleeve", "cloth", faces, albedo, openness.repeat(SECTION), side=side)


def _neck() -> list[Piece]:
    """Neck and nape: one surface in two pieces, of which the close view shows the first."""
    points, normals, faces = polygonised(neck_field, (-0.8, -0.6, -2.00), (0.8, 0.9, -0.55), 0.09)
    behind = points[:, 1] > _NAPE
    aside = (neck_hole(points) > 0.08) & (points[:, 2] < _NECK_HOLE[0][2])
    covered = np.where(points[:, 1] > 0.25, points[:, 2] < -1.20, aside)
    openness = paint.veil(occlusion(neck_field, points, normals)) * _chin_shadow(points)
    front = without(faces, covered | behind)
    back = without(faces[behind[faces].all(axis=1)], covered)
    neck, nape = (compact(Mesh(points, normals, shown, paint.neck(points), openness)) for shown in (front, back))
    return [_turning("neck", "body", neck), _turning("nape", "back", nape)]


def _turning(name: str, space: str, neck: Mesh) -> Piece:
    """Skin that goes along with the head, the more the higher it is."""
    share = smooth((neck.vertices[:, 2] + 1.50) / 0.75)
    return piece(
        name, space, "neck", "skin", neck.faces, neck.albedo, neck.openness, 0.04,
        vertices=neck.vertices, normals=neck.normals, share=share,
    )  # fmt: skip


def _chin_shadow(points: Array) -> Array:
    """The head's shadow on the throat, deepest under the chin."""
    high = smooth((points[:, 2] + 1.62) / 0.70)
    return np.asarray(1 - 0.62 * high * np.clip(0.9 - points[:, 1], 0, 1))


def _jumper() -> Piece:
    points, normals, faces = polygonised(jumper_field, (-1.65, -0.75, -3.9), (1.65, 1.05, -1.2), 0.105)
    behind = (points[:, 1] > 0.75) | (points[:, 2] < -3.85)
    cloth = compact(
        Mesh(
            points,
            normals,
            without(faces, behind),
            plain(palette.JUMPER, len(points)),
            occlusion(jumper_field, points, normals),
        )
    )
    x, y, z = cloth.vertices.T
    chest = np.exp(-(((z + 2.6) / 0.7) ** 2)) * np.clip(0.4 - y, 0, 1)
    swell = np.stack([0.02 * chest * np.sign(x), -0.075 * chest, 0.03 * chest], axis=1)
    lifted = [smooth((x * side - 0.52) / 0.55) * smooth((z + 3.2) / 1.1) for side in (1, -1)]
    return piece(
        "jumper", "body", "jumper", "cloth", cloth.faces, cloth.albedo, cloth.openness,
        vertices=cloth.vertices, normals=cloth.normals, swell=swell, lifted=np.stack(lifted, axis=1),
    )  # fmt: skip


def _band() -> Piece:
    grid = neckband()
    out = grid - grid.mean(axis=0, keepdims=True)
    normals = towards(grid_normals(grid, closed=True), out).reshape(-1, 3)
    faces = both_ways(grid_faces(grid.shape[0], grid.shape[1], closed=True))
    albedo = plain(palette.JUMPER_BAND, len(normals))
    return still(
        "band", "body", "cloth", Mesh(grid.reshape(-1, 3), normals, faces, albedo, np.full(len(normals), 0.85))
    )


def _leaf(side: int) -> Piece:
    grid = collar(side)
    normals = towards(grid_normals(grid, closed=False), grid - np.asarray((0, 0.19, -2.2))).reshape(-1, 3)
    faces = both_ways(grid_faces(grid.shape[0], grid.shape[1], closed=False))
    albedo = plain(palette.COLLAR, len(normals))
    openness = np.linspace(0.62, 1.0, grid.shape[0]).repeat(grid.shape[1])
    return still("collar", "body", "cloth", Mesh(grid.reshape(-1, 3), normals, faces, albedo, openness))
