"""What stands and walks in the room beside the figure."""

from math import pi

import numpy as np
import pytest
from openrois_avatar.engines.animation.gait import Steps
from openrois_avatar.engines.figure import visitor
from openrois_avatar.engines.figure.baked import read
from openrois_avatar.engines.figure.mesh import Array, Mesh
from openrois_avatar.engines.room.plan import HOME, ROOM
from openrois_avatar.engines.room.scene import OtherFigure
from openrois_avatar.engines.room.shot import GROUND, METRE
from openrois_avatar.link.messages import Place


def check(mesh: Mesh) -> None:
    """A mesh is whole, and its faces are seen from outside."""
    count = len(mesh.vertices)
    assert mesh.normals.shape == mesh.albedo.shape == (count, 3)
    assert 0 <= mesh.faces.min() <= mesh.faces.max() < count < 65536
    assert np.isfinite(mesh.vertices).all()
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    area = np.cross(b - a, c - a)
    seen = np.linalg.norm(area, axis=1) > 1e-7
    assert (np.einsum("ij,ij->i", area, mesh.normals[mesh.faces[:, 0]])[seen] > 0).mean() > 0.9


def room(name: str) -> Mesh:
    return next(piece.mesh() for piece in read("room") if piece.name == name)


def test_furniture_stands_where_the_plan_says() -> None:
    mesh = room("furniture")
    check(mesh)
    assert mesh.vertices[:, 2].min() == pytest.approx(GROUND)
    for piece in ROOM.furniture:
        corners = np.asarray(piece.outline) * METRE
        low, high = corners.min(axis=0) - 0.5, corners.max(axis=0) + 0.5
        inside = ((mesh.vertices[:, :2] > low) & (mesh.vertices[:, :2] < high)).all(axis=1)
        top = GROUND + piece.height * METRE
        assert top - 2.5 < mesh.vertices[inside, 2].max() < top + 2.5, piece.name


def test_the_floor_is_as_large_as_the_plan() -> None:
    mesh = room("floor")
    check(mesh)
    corners = np.asarray(ROOM.outline) * METRE
    assert mesh.vertices[:, :2].min(axis=0) == pytest.approx(corners.min(axis=0), abs=1e-6)
    assert mesh.vertices[:, :2].max(axis=0) == pytest.approx(corners.max(axis=0), abs=1e-6)
    assert set(mesh.vertices[:, 2]) == {GROUND}


@pytest.fixture(scope="module")
def limbs() -> dict[visitor.Limb, Mesh]:
    return visitor.build()


def test_the_visitor_is_sound_and_small(limbs: dict[visitor.Limb, Mesh]) -> None:
    for mesh in limbs.values():
        check(mesh)
    assert sum(len(mesh.faces) for mesh in limbs.values()) < 12_000


def middle(limbs: dict[visitor.Limb, Mesh], limb: visitor.Limb, other: OtherFigure) -> Array:
    frame = visitor.frames(other)[limb]
    return np.asarray(frame.rotation @ limbs[limb].vertices.mean(axis=0) + frame.origin)


def test_the_visitor_is_where_it_is(limbs: dict[visitor.Limb, Mesh]) -> None:
    there = OtherFigure(Place(1.0, 2.0, pi))
    head = middle(limbs, "head", there)
    assert head[:2] == pytest.approx((METRE, 2 * METRE), abs=0.6)
    assert middle(limbs, "foot_left", there)[2] < GROUND + 0.6
    # It looks to the left of the picture: its left foot is nearer to the viewer.
    assert middle(limbs, "foot_left", there)[1] < middle(limbs, "foot_right", there)[1]


def test_the_visitor_swings_its_arms_against_its_legs(limbs: dict[visitor.Limb, Mesh]) -> None:
    steps, apart = Steps(), []
    for _ in range(90):
        steps.advance(0.8, 0.0, 0.0, 1 / 60)
        other = OtherFigure(HOME, steps.channels())
        legs = middle(limbs, "shin_left", other)[1] - middle(limbs, "shin_right", other)[1]
        arms = middle(limbs, "arm_left", other)[1] - middle(limbs, "arm_right", other)[1]
        apart.append((legs, arms))
    stepping = [legs * arms for legs, arms in apart if abs(legs) > 0.8]
    assert len(stepping) > 20
    assert max(stepping) < 0
