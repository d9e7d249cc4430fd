"""Triangle meshes as plain arrays, and the grids they are woven from.

Axes, everywhere in this package: x to the right of the picture, y away from the viewer, z up. The face looks along -y.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int32]


@dataclass(frozen=True)
class Mesh:
    """Vertices and unit normals (n, 3), counter-clockwise faces (m, 3), linear albedo (n, 3), openness (n,) 0..1."""

    vertices: Array
    normals: Array
    faces: Faces
    albedo: Array
    openness: Array


def grid_faces(rows: int, columns: int, closed: bool) -> Faces:
    """Triangles of a grid of rows x columns vertices, row-major; `closed` joins the last column to the first."""
    index = np.arange(rows * columns).reshape(rows, columns)
    following = np.roll(index, -1, axis=1) if closed else index[:, 1:]
    here = index if closed else index[:, :-1]
    a, b, c, d = here[:-1].ravel(), following[:-1].ravel(), following[1:].ravel(), here[1:].ravel()
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).astype(np.int32)


def grid_normals(points: Array, closed: bool) -> Array:
    """Unit normals of a grid, shape (rows, columns, 3), seen from the side where `grid_faces` winds to the left."""
    down = np.empty_like(points)
    down[1:-1] = points[2:] - points[:-2]
    down[0], down[-1] = points[1] - points[0], points[-1] - points[-2]
    across = np.empty_like(points)
    across[:, 1:-1] = points[:, 2:] - points[:, :-2]
    if closed:
        across[:, 0], across[:, -1] = points[:, 1] - points[:, -1], points[:, 0] - points[:, -2]
    else:
        across[:, 0], across[:, -1] = points[:, 1] - points[:, 0], points[:, -1] - points[:, -2]
    normals = crossed(across, down)
    return np.asarray(normals / np.maximum(np.sqrt((normals * normals).sum(axis=2, keepdims=True)), 1e-12))


def towards(normals: Array, axis: Array) -> Array:
    """Normals turned over where they point away from `axis`, shape (..., 3) or (3,)."""
    against = (normals * axis).sum(axis=-1, keepdims=True) < 0
    return np.asarray(np.where(against, -normals, normals))


def crossed(first: Array, second: Array) -> Array:
    """Cross products along the last axis; several times quicker than NumPy's for small arrays."""
    ax, ay, az = first[..., 0], first[..., 1], first[..., 2]
    bx, by, bz = second[..., 0], second[..., 1], second[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def smooth(value: Array) -> Array:
    """Smoothstep of a value clipped to 0..1."""
    clipped = np.clip(value, 0.0, 1.0)
    return np.asarray(clipped * clipped * (3 - 2 * clipped))
