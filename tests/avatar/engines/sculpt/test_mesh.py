import numpy as np
import pytest
from openrois_avatar.engines.sculpt.distance import Array, ellipsoid, join
from openrois_avatar.engines.sculpt.mesh import (
    Faces,
    Mesh,
    compact,
    crossed,
    grid_faces,
    grid_normals,
    merged,
    polygonised,
    without,
)


def plane(rows: int, columns: int) -> Array:
    x, y = np.meshgrid(np.arange(columns, dtype=float), np.arange(rows, dtype=float))
    return np.stack([x, y, np.zeros_like(x)], axis=-1)


def facing(points: Array, faces: Faces) -> Array:
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


@pytest.mark.parametrize("closed", [False, True])
def test_a_grid_is_covered_once(closed: bool) -> None:
    faces = grid_faces(3, 4, closed)
    assert faces.shape == (2 * 2 * (4 if closed else 3), 3)
    assert set(faces.ravel()) == set(range(12))


def test_normals_and_faces_of_a_grid_agree() -> None:
    points = plane(3, 4)
    assert grid_normals(points, closed=False).reshape(-1, 3) == pytest.approx(np.tile((0.0, 0.0, 1.0), (12, 1)))
    assert (facing(points.reshape(-1, 3), grid_faces(3, 4, closed=False))[:, 2] > 0).all()


def test_the_normals_of_a_tube_point_away_from_its_axis() -> None:
    angle = np.arange(16) * np.pi / 8
    rows = [np.stack([np.cos(angle), np.sin(angle), np.full_like(angle, z)], axis=1) for z in (0.0, 1.0, 2.0)]
    tube = np.stack(rows)
    assert grid_normals(tube, closed=True) == pytest.approx(tube * (1, 1, 0), abs=1e-9)


def test_crossed_is_the_cross_product() -> None:
    random = np.random.default_rng(1)
    first, second = random.normal(size=(4, 5, 3)), random.normal(size=(4, 5, 3))
    assert crossed(first, second) == pytest.approx(np.cross(first, second))


def test_faces_go_only_when_all_their_vertices_are_hidden() -> None:
    faces = np.asarray([(0, 1, 2), (1, 2, 3)], np.int32)
    assert without(faces, np.asarray([True, True, True, False])).tolist() == [[1, 2, 3]]


def test_compact_keeps_what_is_used_and_merged_keeps_all() -> None:
    points = plane(1, 4).reshape(-1, 3)
    mesh = Mesh(points, points, np.asarray([(1, 2, 3)], np.int32), points, np.ones(4))
    small = compact(mesh)
    assert small.vertices.tolist() == points[1:].tolist()
    assert small.faces.tolist() == [[0, 1, 2]]
    both = merged([small, mesh])
    assert len(both.vertices) == len(both.normals) == len(both.albedo) == len(both.openness) == 7
    assert both.faces.tolist() == [[0, 1, 2], [4, 5, 6]]


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
