"""Meshes of the rooms: what faces the robot is drawn, and light falls from above."""

import numpy as np
import pytest
from openrois_robots.simulated.drawing.furnishing import (
    CEILING,
    HEAD,
    floor_mesh,
    furniture_mesh,
    mat_mesh,
    person_body,
    person_head,
    walls_mesh,
)
from openrois_robots.simulated.drawing.meshes import Mesh, ball, box, disc, plane, tube
from openrois_robots.simulated.world.plan import APARTMENT

pytestmark = pytest.mark.extra(name="robot")

RED = (0.8, 0.1, 0.1)
SOLIDS = {
    "box": box((-1, -1, 0), (1, 1, 1), RED),
    "ball": ball(1.0, 0.5, 0.7, RED),
    "tube": tube([(0, 0.3, 0), (0.5, 0.4, 0), (1, 0.2, 0)], RED),
}


def outwards(mesh: Mesh) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return for each triangle with an area whether its front is on the side away from the middle axis."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]].astype(np.float64) for corner in range(3))
    normals = np.cross(b - a, c - a)
    is_there = np.linalg.norm(normals, axis=1) > 1e-9
    away = (a + b + c) / 3 - mesh.vertices.mean(axis=0)
    return np.asarray((normals * away).sum(axis=1)[is_there] > 0)


@pytest.mark.parametrize("name", SOLIDS)
def test_the_front_of_a_solid_is_outside(name: str) -> None:
    assert outwards(SOLIDS[name]).all()


@pytest.mark.parametrize("mesh", [plane((0, 0, 0), (3, 0, 0), (0, 2, 0), RED, 0.5), disc(0, 0, 0, 1, RED, RED)])
def test_what_lies_on_the_floor_is_seen_from_above(mesh: Mesh) -> None:
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_light_falls_from_above() -> None:
    red, normal = SOLIDS["box"].colours[:, 0], SOLIDS["box"].vertices[:, 2]
    assert red[normal == 1].max() == red.max()
    assert red.min() < 0.75 * red.max()


def test_a_mesh_that_is_turned_and_moved_keeps_its_shape() -> None:
    moved = box((0, 0, 0), (1, 2, 3), RED).turned(np.pi / 2, 5, 0)
    assert moved.vertices.min(axis=0) == pytest.approx((3, 0, 0), abs=1e-5)
    assert moved.vertices.max(axis=0) == pytest.approx((5, 1, 3), abs=1e-5)


def test_everything_is_drawn_where_the_plan_has_it() -> None:
    for piece in APARTMENT.furniture:
        mesh = furniture_mesh(piece)
        (left, bottom), _, (right, top), _ = piece.outline
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        near = 0.25 if piece.look == "plant" else 0.13
        assert low == pytest.approx((left, bottom, 0.0), abs=near), piece.name
        assert high == pytest.approx((right, top, piece.height), abs=near), piece.name
    walls = walls_mesh(APARTMENT).vertices
    assert walls.min(axis=0) == pytest.approx((-5, -3.5, 0))
    assert walls.max(axis=0) == pytest.approx((5, 3.5, CEILING))
    floors = [floor_mesh(room).vertices for room in APARTMENT.rooms]
    assert np.concatenate(floors).min(axis=0) == pytest.approx((-5, -3.5, 0))
    assert np.concatenate(floors).max(axis=0) == pytest.approx((5, 3.5, 0))
    mat = mat_mesh(APARTMENT.mat).vertices
    assert np.hypot(*(mat[:, :2] - (APARTMENT.mat.x, APARTMENT.mat.y)).T).max() == pytest.approx(0.85, abs=1e-5)


def test_a_person_is_a_person_high() -> None:
    body, head = person_body(APARTMENT.persons[0]), person_head()
    assert head.vertices[:, 2].mean() == pytest.approx(HEAD, abs=0.02)
    assert 1.65 < head.vertices[:, 2].max() < 1.8
    assert body.vertices[:, 2].max() > head.vertices[:, 2].min(), "there is a neck"


def test_colours_can_be_shown() -> None:
    for mesh in (*map(furniture_mesh, APARTMENT.furniture), walls_mesh(APARTMENT), *map(floor_mesh, APARTMENT.rooms)):
        assert mesh.colours.min() >= 0
        assert mesh.colours.max() <= 1
        assert len(mesh.colours) == len(mesh.places) == len(mesh.vertices) < 65_536
        assert mesh.faces.max() < len(mesh.vertices)
