"""The parts of the head that are skin, skull and jaw, lids, lips, ears; and what is in the mouth."""

import numpy as np
from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Mouth
from openrois_avatar.engines.figure.baked import Piece
from openrois_avatar.engines.figure.eyes import SPOKES, Lids
from openrois_avatar.engines.figure.head import DepthMap
from openrois_avatar.engines.figure.mesh import Array, Mesh, grid_faces, grid_normals, towards
from openrois_avatar.engines.figure.mouth import BORDER, INSIDE, RINGS, Lips, cavity
from openrois_avatar.engines.figure.mouth import SPOKES as MOUTH_SPOKES
from openrois_avatar.engines.figure.shading import linear

from tools.sculpt import head, mouth, paint
from tools.sculpt.distance import ellipsoid, occlusion
from tools.sculpt.mesh import compact, polygonised, without
from tools.sculpt.pieces import both_ways, piece, plain, sided, still

_SKIN_GLOSS = 0.09
_LIP_GLOSS = 0.24


def pieces(depth: Array, shadow: paint.Shadow) -> list[Piece]:
    """Everything, on a face of this depth; `shadow` darkens what lies under the hair."""
    lips = mouth.LipsAtRest(DepthMap(depth))
    return [
        _skull(shadow),
        *_ear(),
        _lips(lips, DepthMap(depth), shadow),
        *_inside_mouth(lips),
        *(_lid(depth, shadow, side) for side in (1, -1)),
    ]


def _skull(shadow: paint.Shadow) -> Piece:
    points, normals, faces = polygonised(head.face_field, (-1.0, -1.2, -1.1), (1.0, 1.2, 1.3), 0.05)
    hair_side = (points[:, 1] > 0.22) | (points[:, 2] > 0.88)
    faces = without(without(faces, head.in_patch(points, 0.06)), hair_side)
    openness = paint.veil(occlusion(head.face_field, points, normals)) * shadow(points)
    skull = compact(Mesh(points, normals, faces, paint.skin(points), openness))
    share = head.jaw_share(skull.vertices)
    return piece(
        "skull", "head", "skull", "skin", skull.faces, skull.albedo, skull.openness, _SKIN_GLOSS,
        vertices=skull.vertices, normals=skull.normals, share=share,
    )  # fmt: skip


def _ear() -> list[Piece]:
    """The right ear with its earring; the hair falls over the left one."""
    points, normals, faces = polygonised(head.ear_field, (0.62, -0.30, -0.50), (1.05, 0.35, 0.25), 0.036)
    openness = occlusion(head.ear_field, points, normals, 0.12)
    ear = Mesh(points, normals, faces, paint.ear(points, openness), paint.veil(openness))
    place = np.asarray(head.PEARL)
    points, normals, faces = polygonised(lambda p: ellipsoid(p, place, (0.042,) * 3), place - 0.07, place + 0.07, 0.024)
    pearl = Mesh(points, normals, faces, plain(palette.PEARL, len(points)), np.ones(len(points)))
    return [
        still("ear", "head", "skin", ear, _SKIN_GLOSS, side=-1),
        still("pearl", "head", "skin", pearl, 0.5, side=-1),
    ]


def _openness(grid: Array, depth: DepthMap) -> Array:
    """Openness of the smooth face under a patch, (n,): the same as the skull's where they meet."""
    x, z = grid[..., 0], grid[..., 2]
    surface = np.stack([x, depth(x, z), z], axis=-1).reshape(-1, 3)
    return paint.veil(occlusion(head.face_field, surface, head.normals_of_face(depth, x, z).reshape(-1, 3)))


def _lid(depth: Array, shadow: paint.Shadow, side: int) -> Piece:
    face = DepthMap(depth)
    rest = Lids(face).grid(0.0, 0.0, 0.0)
    flat = rest.reshape(-1, 3)
    albedo = paint.skin(flat).reshape(rest.shape)
    for ring, share in enumerate((0.75, 0.45, 0.28, 0.14, 0.05)):
        albedo[ring] += (linear(palette.LID_SHADE) - albedo[ring]) * share
    openness = _openness(rest, face) * shadow(flat * (side, 1, 1))
    faces = sided(grid_faces(len(rest), SPOKES, closed=True)[:, ::-1], side)
    skin_normals = head.normals_of_face(face, rest[..., 0], rest[..., 2])
    return piece(
        "lid", "head", "lid", "skin", faces, albedo.reshape(-1, 3), openness, _SKIN_GLOSS, side,
        depth=depth, skin_normals=skin_normals,
    )  # fmt: skip


def _lips(lips: mouth.LipsAtRest, depth: DepthMap, shadow: paint.Shadow) -> Piece:
    rest = Lips(lips.rest, lips.jaw).grid(Mouth())
    flat = rest.reshape(-1, 3)
    albedo = paint.skin(flat).reshape(rest.shape)
    gloss = np.full(rest.shape[:2], _SKIN_GLOSS)
    for ring in range(BORDER + 1):
        share = 1.0 if ring < BORDER else 0.45
        albedo[ring] += (linear(palette.LIPS) - albedo[ring]) * share
        gloss[ring] += (_LIP_GLOSS - gloss[ring]) * share
    albedo[: INSIDE + 1] *= np.asarray((0.12, 0.25, 0.5, 0.74))[:, None, None]
    gloss[:INSIDE] = 0.0
    faces = grid_faces(RINGS, MOUTH_SPOKES, closed=True)[:, ::-1]
    openness = _openness(rest, depth) * shadow(flat)
    return piece(
        "lips", "head", "lips", "skin", faces, albedo.reshape(-1, 3), openness, gloss.ravel(),
        rest=lips.rest, jaw=lips.jaw, skin_normals=lips.skin_normals,
    )  # fmt: skip


def _inside_mouth(lips: mouth.LipsAtRest) -> list[Piece]:
    return [
        _firm("upper teeth", mouth.teeth(upper=True), palette.TEETH, mouth.teeth_openness(0.65)),
        _firm("lower teeth", mouth.teeth(upper=False), palette.TEETH, mouth.teeth_openness(0.32)),
        _firm("tongue", mouth.tongue(), palette.TONGUE, np.asarray(0.60)),
        _cavity(lips),
    ]


def _cavity(lips: mouth.LipsAtRest) -> Piece:
    rows, columns, _ = cavity(lips.rest[0]).shape
    faces = both_ways(grid_faces(rows, columns, closed=True))
    albedo = plain(palette.MOUTH_INSIDE, rows * columns)
    return piece("cavity", "head", "cavity", "plain", faces, albedo, 0.0, rest=lips.rest, jaw=lips.jaw)


def _firm(name: str, grid: Array, colour: str, openness: Array) -> Piece:
    """Something in the mouth that keeps its shape while it moves."""
    normals = towards(grid_normals(grid, closed=False), np.asarray((0.0, -1.0, 0.0))).reshape(-1, 3)
    faces = both_ways(grid_faces(grid.shape[0], grid.shape[1], closed=False))
    albedo = plain(colour, len(normals))
    vertices = grid.reshape(-1, 3)
    return piece(name, "head", name, "plain", faces, albedo, openness, vertices=vertices, normals=normals)
