"""Pieces of a figure as they are baked: a mesh with its colours, and the name of how it moves."""

import numpy as np
import numpy.typing as npt
from openrois_avatar.engines.figure.baked import Arrays, Piece
from openrois_avatar.engines.figure.mesh import Array, Faces, Mesh
from openrois_avatar.engines.figure.shading import linear


def piece(
    name: str,
    space: str,
    motion: str,
    finish: str,
    faces: Faces,
    albedo: Array,
    openness: npt.ArrayLike = 1.0,
    gloss: npt.ArrayLike = 0.0,
    side: int = 1,
    **arrays: Array,
) -> Piece:
    """A piece that moves, with openness and gloss of each vertex or one for all; its motion has the other arrays."""
    count = len(albedo)

    def each(value: npt.ArrayLike) -> Array:
        return np.array(np.broadcast_to(np.asarray(value, float), (count,)))

    common: Arrays = {"faces": faces, "albedo": albedo, "openness": each(openness), "gloss": each(gloss)}
    return Piece(name, space, motion, side, finish, {**common, **arrays})


def still(name: str, space: str, finish: str, mesh: Mesh, gloss: float = 0.0, side: int = 1) -> Piece:
    """A piece that never changes its shape; for side -1 it is the mesh of the body's other side."""
    return piece(
        name,
        space,
        "still",
        finish,
        sided(mesh.faces, side),
        mesh.albedo,
        mesh.openness,
        gloss,
        side,
        vertices=mesh.vertices,
        normals=mesh.normals,
    )


def plain(colour: str, count: int) -> Array:
    """The albedo (n, 3) of a surface of one colour."""
    return np.tile(linear(colour), (count, 1))


def sided(faces: Faces, side: int) -> Faces:
    """Faces wound for the side their vertices are mirrored to."""
    return faces if side > 0 else faces[:, ::-1]


def both_ways(faces: Faces) -> Faces:
    """Faces that are seen from both sides."""
    return np.concatenate([faces, faces[:, ::-1]])
