"""Meshes that are made: from fields, and from other meshes."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from openrois_avatar.engines.figure.mesh import Array, Faces, Mesh

from tools.sculpt.distance import Field, Triple, gradient


def without(faces: Faces, hidden: npt.NDArray[np.bool_]) -> Faces:
    """The faces that keep at least one vertex that is not hidden."""
    return np.asarray(faces[~hidden[faces].all(axis=1)])


def compact(mesh: Mesh) -> Mesh:
    """The same mesh without the vertices that no face uses."""
    used = np.unique(mesh.faces)
    renumber = np.zeros(len(mesh.vertices), np.int32)
    renumber[used] = np.arange(len(used), dtype=np.int32)
    return Mesh(mesh.vertices[used], mesh.normals[used], renumber[mesh.faces], mesh.albedo[used], mesh.openness[used])


def merged(meshes: Sequence[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]).astype(np.int32),
        np.concatenate([mesh.albedo for mesh in meshes]),
        np.concatenate([mesh.openness for mesh in meshes]),
    )


def polygonised(field: Field, low: Triple, high: Triple, cell: float) -> tuple[Array, Array, Faces]:
    """Vertices, normals and triangles of the field's surface inside a box (surface nets, then Newton steps onto it)."""
    counts = [int(np.ceil((end - start) / cell)) + 1 for start, end in zip(low, high, strict=True)]
    axes = [float(start) + cell * np.arange(count, dtype=np.float64) for start, count in zip(low, counts, strict=True)]
    samples = _banded(field, axes, cell)
    points, faces = _surface_net(samples, np.asarray(low, float), cell)
    for _ in range(3):
        normals = gradient(field, points)
        points = points - normals * field(points)[:, None] * 0.8
    return points, gradient(field, points), faces


def _banded(field: Field, axes: Sequence[Array], cell: float) -> Array:
    """Samples on the grid; where a coarse look already says `far`, the coarse value stands in."""
    stride = 4
    coarse_axes = [np.append(axis[::stride], axis[-1] + cell * stride) for axis in axes]
    coarse = field(_lattice(coarse_axes)).reshape([len(axis) for axis in coarse_axes])
    fine = coarse
    for axis, points in enumerate(axes):
        fine = np.repeat(fine, stride, axis=axis).take(np.arange(len(points)), axis=axis)
    # A cell of the coarse lattice is represented by its low corner: anything within its diagonal may hold surface.
    near = np.abs(fine) < cell * stride * 2.0
    fine = fine.copy()
    fine[near] = field(_lattice(axes)[near.ravel()])
    return np.asarray(fine)


def _lattice(axes: Sequence[Array]) -> Array:
    return np.stack([part.ravel() for part in np.meshgrid(*axes, indexing="ij")], axis=1)


_CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
_EDGES = [(a, b) for a in range(8) for b in range(a + 1, 8) if bin(a ^ b).count("1") == 1]


def _surface_net(samples: Array, low: Array, cell: float) -> tuple[Array, Faces]:
    shape = [size - 1 for size in samples.shape]
    corners = [samples[i : i + shape[0], j : j + shape[1], k : k + shape[2]] for i, j, k in _CORNERS]
    inside = sum((corner < 0).astype(np.int8) for corner in corners)
    active = (inside > 0) & (inside < 8)
    cells = np.argwhere(active)
    values = np.stack([corner[active] for corner in corners], axis=1)
    total, hits = np.zeros((len(cells), 3)), np.zeros(len(cells))
    offsets = np.asarray(_CORNERS, float)
    for a, b in _EDGES:
        crossing = (values[:, a] < 0) != (values[:, b] < 0)
        part = values[crossing, a] / (values[crossing, a] - values[crossing, b])
        total[crossing] += offsets[a] + part[:, None] * (offsets[b] - offsets[a])
        hits[crossing] += 1
    points = low + cell * (cells + total / hits[:, None])
    number = np.full(shape, -1, np.int32)
    number[active] = np.arange(len(cells), dtype=np.int32)
    return points, _net_faces(samples, number)


def _net_faces(samples: Array, number: npt.NDArray[np.int32]) -> Faces:
    """Two triangles for each lattice edge that crosses the surface, over the four cells around it."""
    faces: list[Faces] = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        near = np.moveaxis(samples, (axis, u, v), (0, 1, 2))
        cells = np.moveaxis(number, (axis, u, v), (0, 1, 2))
        start, end = near[:-1, 1:-1, 1:-1] < 0, near[1:, 1:-1, 1:-1] < 0
        around = [cells[:, :-1, :-1], cells[:, 1:, :-1], cells[:, 1:, 1:], cells[:, :-1, 1:]]
        for crossing, order in ((start & ~end, (0, 1, 2, 3)), (~start & end, (3, 2, 1, 0))):
            a, b, c, d = (around[corner][crossing] for corner in order)
            faces += [np.stack([a, b, c], 1), np.stack([a, c, d], 1)]
    return np.concatenate(faces)
