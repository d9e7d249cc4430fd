import numpy as np
import pytest
from openrois_avatar.engines.figure.mesh import Array, Faces, Mesh

from tools.sculpt.distance import ellipsoid, join
from tools.sculpt.mesh import compact, merged, polygonised, without


def test_faces_go_only_when_all_their_vertices_are_hidden() -> None:
    faces = np.asarray([(0, 1, 2), (1, 2, 3)], np.int32)
    assert without(faces, np.asarray([True, True, True, False])).tolist() == [[1, 2, 3]]


def test_compact_keeps_what_is_used_and_merged_keeps_all() -> None:
    points = np.asarray([(x, 0, 0) for x in range(4)], float)
    mesh = Mesh(points, points, np.asarray([(1, 2, 3)], np.int32), points, np.ones(4))
    small = compact(mesh)
    assert small.vertices.tolist() == points[1:].tolist()
    assert small.faces.tolist() == [[0, 1, 2]]
    both = merged([small, mesh])
    assert len(both.vertices) == len(both.normals) == len(both.albedo) == len(both.openness) == 7
    assert both.faces.tolist() == [[0, 1, 2], [4, 5, 6]]


def facing(points: Array, faces: Faces) -> Array:
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def peanut(points: Array) -> Array:
    first, second = (ellipsoid(points, (x, 0, 0), (0.6, 0.5, 0.5)) for x in (-0.4, 0.4))
    return join(first, second, 0.2)


def test_a_surface_is_closed_lies_on_the_field_and_faces_outwards() -> None:
    points, normals, faces = polygonised(peanut, (-1.3, -0.8, -0.8), (1.3, 0.8, 0.8), 0.08)
    assert np.abs(peanut(points)).max() < 0.005
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there, back = {tuple(edge) for edge in edges.tolist()}, {tuple(edge) for edge in edges[:, ::-1].tolist()}
    assert there == back
    outwards = np.einsum("ij,ij->i", facing(points, faces), normals[faces[:, 0]])
    assert (outwards > 0).mean() > 0.99
