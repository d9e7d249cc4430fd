import numpy as np
import pytest
from openrois_avatar.engines.figure.mesh import Array, Faces, crossed, grid_faces, grid_normals


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
