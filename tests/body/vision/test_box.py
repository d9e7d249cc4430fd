"""Boxes in pictures, and places in the room."""

import math

import pytest
from openrois_body.sensing.changes import Place
from openrois_body.vision.box import FACE_WIDTH, FIELD_OF_VIEW, Box, Face, Motion, place_of, place_on_floor

HERE = Box(0.4, 0.3, 0.2, 0.4)


@pytest.mark.parametrize(
    ("other", "overlap"),
    [(HERE, 1.0), (Box(0.5, 0.3, 0.2, 0.4), 1 / 3), (Box(0.6, 0.3, 0.2, 0.4), 0.0), (Box(0.4, 0.8, 0.2, 0.4), 0.0)],
)
def test_overlap(other: Box, overlap: float) -> None:
    assert HERE.overlap(other) == pytest.approx(overlap)
    assert other.overlap(HERE) == pytest.approx(overlap)


def test_a_face_moves_grows_around_its_middle_and_leans() -> None:
    face = Face(HERE, 0.1).moved(Motion(0.1, -0.05, 1.5, 0.2))
    assert face.box.centre == pytest.approx((0.6, 0.45))
    assert face.box[2:] == pytest.approx((0.3, 0.6))
    assert face.roll == pytest.approx(0.3)


def test_between() -> None:
    assert HERE.between(Box(0.5, 0.3, 0.3, 0.6), 0.5) == pytest.approx((0.45, 0.3, 0.25, 0.5))


@pytest.mark.parametrize("metres", [0.4, 1.0, 3.0])
@pytest.mark.parametrize("right", [-0.3, 0.0, 0.2])
@pytest.mark.parametrize("aspect", [16 / 9, 1.0, 9 / 16])
def test_a_face_that_a_pinhole_camera_shows_is_where_it_was(metres: float, right: float, aspect: float) -> None:
    # The longer side of the picture has the field of view.
    focal = (max(aspect, 1.0) / aspect) * 0.5 / math.tan(FIELD_OF_VIEW / 2)
    width = focal * FACE_WIDTH / metres
    middle = 0.5 + focal * right / metres
    place = place_of(Box(middle - width / 2, 0.4, width, width * aspect), aspect)
    assert (place.x, place.y) == pytest.approx((right, metres))
    assert math.cos(place.th - math.atan2(-metres, -right)) == pytest.approx(1.0)


def test_face_straight_ahead_faces_the_camera() -> None:
    assert place_of(Box(0.4, 0.4, 0.2, 0.2), 1.0).th == pytest.approx(-math.pi / 2)


@pytest.mark.parametrize(
    ("camera", "seen", "there"),
    [
        (Place(0, 0, math.pi / 2), Place(0.5, 2, -math.pi / 2), Place(0.5, 2, -math.pi / 2)),
        (Place(1, -1, 0), Place(0.5, 2, -math.pi / 2), Place(3, -1.5, math.pi)),
        (Place(1, -1, math.pi), Place(-0.5, 2, -math.pi / 2), Place(-1, -1.5, 0)),
    ],
)
def test_what_is_right_of_a_camera_is_right_of_where_it_looks(camera: Place, seen: Place, there: Place) -> None:
    place = place_on_floor(seen, camera)
    assert (place.x, place.y) == pytest.approx((there.x, there.y))
    assert math.cos(place.th - there.th) == pytest.approx(1)
    assert -math.pi <= place.th <= math.pi


def test_a_camera_that_looks_up_sees_the_way_to_a_face_shorter_than_it_is() -> None:
    place = place_on_floor(Place(0, 2, -math.pi / 2), Place(0, 0, 0), 0.3)
    assert (place.x, place.y) == pytest.approx((2 / math.cos(0.3), 0))
