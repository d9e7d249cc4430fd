import numpy as np
import pytest
from openrois_avatar.engines.figure.mesh import Array

from tools.sculpt.distance import (
    carve,
    cone,
    ellipsoid,
    gradient,
    join,
    march,
    mirrored,
    occlusion,
)


def ball(points: Array) -> Array:
    return ellipsoid(points, (0, 0, 0), (1, 1, 1))


POINTS = np.asarray([(0.5, 0, 0), (1, 0, 0), (0, 0, 2.5)], float)


def test_a_ball_is_as_far_as_it_is() -> None:
    assert ball(POINTS) == pytest.approx([-0.5, 0.0, 1.5])


def test_a_cone_has_its_radii_at_its_ends() -> None:
    points = np.asarray([(0.4, 0, 0), (0.2, 0, 1), (0, 0, 1.3), (0.3, 0, 0.5)], float)
    assert cone(points, (0, 0, 0), (0, 0, 1), 0.4, 0.2) == pytest.approx([0, 0, 0.1, 0], abs=1e-9)


def test_joining_fills_the_seam_and_carving_rounds_it() -> None:
    assert join(np.asarray([0.1]), np.asarray([0.1]), 0.2)[0] < 0.1
    assert join(np.asarray([0.1]), np.asarray([0.9]), 0.2)[0] == 0.1
    assert carve(np.asarray([-0.1]), np.asarray([-0.5]), 0.2)[0] == pytest.approx(0.5)
    assert carve(np.asarray([-0.1]), np.asarray([0.5]), 0.2)[0] == pytest.approx(-0.1)


def test_mirroring_folds_and_leaves_its_argument_alone() -> None:
    points = np.asarray([(-1.0, 2.0, 3.0)])
    assert mirrored(points).tolist() == [[1.0, 2.0, 3.0]]
    assert points.tolist() == [[-1.0, 2.0, 3.0]]


def test_normals_point_outwards() -> None:
    assert gradient(ball, np.asarray([(0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)])) == pytest.approx(
        np.asarray([(0, 0, 1), (-1, 0, 0)]), abs=1e-6
    )


def test_a_ray_stops_at_the_surface_or_at_its_reach() -> None:
    origins = np.asarray([(0.0, -3.0, 0.0), (2.0, -3.0, 0.0)])
    ahead = np.asarray([(0.0, 1.0, 0.0), (0.0, 1.0, 0.0)])
    assert march(ball, origins, ahead, 4.0) == pytest.approx([2.0, 4.0], abs=1e-3)


def test_a_fold_is_less_open_than_a_hill() -> None:
    def valley(points: Array) -> Array:
        return np.minimum(points[:, 2], ellipsoid(points, (0.7, 0, 0.3), (0.6, 5, 0.6)))

    up = np.asarray([(0.0, 0.0, 1.0)])
    near, far = (occlusion(valley, np.asarray([(x, 0.0, 0.0)]), up)[0] for x in (0.05, -3.0))
    assert near < 0.8
    assert far == pytest.approx(1.0)
