from itertools import pairwise
from math import pi

import pytest
from openrois_avatar.engines.room.plan import HOME
from openrois_avatar.engines.room.shot import DISTANCE, EYE_LEVEL, HOME_SHOT, METRE, Camerawork, Shot, own_shot, shot
from openrois_avatar.engines.room.walking import Pace
from openrois_avatar.link.messages import Place

FRAME = 1 / 30
WALKING = Pace(ahead=0.8)


def shots(
    camera: Camerawork, place: Place, pace: Pace, seconds: float, start: float, talks: bool = False
) -> list[Shot]:
    return [camera.follow(start + number * FRAME, place, pace, talks) for number in range(round(seconds / FRAME))]


def test_a_figure_at_home_is_seen_closely() -> None:
    assert Shot(0.0, -DISTANCE, EYE_LEVEL, 0.0) == HOME_SHOT
    assert set(shots(Camerawork(0.0), HOME, Pace(), 1.0, 0.0)) == {HOME_SHOT}
    assert HOME_SHOT.is_close


def test_camera_backs_off_from_a_walking_figure_and_comes_near_when_it_stands() -> None:
    camera = Camerawork(0.0)
    away = shots(camera, Place(1.0, 1.0, -pi / 2), WALKING, 4.0, 0.0)
    assert away[-1].y < -40
    assert away[-1].tilt > 0.1
    assert 0 < away[-1].x < METRE
    back = shots(camera, Place(1.0, 1.0, -pi / 2), Pace(), 8.0, 4.0)
    assert back[20].y < -40
    assert back[-1] == shot(1.0, 1.0, 0.0)
    assert back[-1].is_close


def test_camera_never_jumps() -> None:
    camera = Camerawork(0.0)
    seen = shots(camera, Place(1.0, 2.0, -pi / 2), WALKING, 3.0, 0.0)
    seen += shots(camera, Place(1.0, 2.0, -pi / 2), Pace(), 3.0, 3.0)
    seen += shots(camera, Place(0.5, 1.0, 0.0), WALKING, 3.0, 6.0, talks=True)
    for before, after in pairwise(seen):
        assert abs(after.y - before.y) < 4.0
        assert abs(after.x - before.x) < 0.6


def test_camera_stays_closer_to_a_walking_figure_that_talks() -> None:
    silent, talking = (shots(Camerawork(0.0), HOME, WALKING, 5.0, 0.0, talks=talks)[-1] for talks in (False, True))
    assert silent.y < talking.y - 10
    assert not talking.is_close


def test_camera_does_not_back_off_when_talking_and_walking_stop() -> None:
    camera = Camerawork(0.0)
    last = shots(camera, HOME, WALKING, 4.0, 0.0, talks=True)[-1]
    assert min(seen.y for seen in shots(camera, HOME, Pace(), 4.0, 4.0)) > last.y - 0.5


def test_camera_does_not_come_near_to_a_figure_seen_from_behind() -> None:
    camera = Camerawork(0.0)
    shots(camera, Place(0.0, 1.0, pi / 2), WALKING, 3.0, 0.0)
    away = shots(camera, Place(0.0, 1.0, pi / 2), Pace(), 8.0, 3.0)[-1]
    assert not away.is_close


def test_figure_in_the_picture_is_known() -> None:
    assert HOME_SHOT.sees(Place(0.0, 2.0, 0.0), 16 / 9)
    assert HOME_SHOT.sees(Place(1.2, 2.0, 0.0), 16 / 9)
    assert not HOME_SHOT.sees(Place(2.0, 2.0, 0.0), 16 / 9)
    assert not HOME_SHOT.sees(Place(-1.2, 2.0, 0.0), 0.5)
    assert not HOME_SHOT.sees(Place(0.0, -1.8, 0.0), 16 / 9)


def test_a_long_pause_is_no_jump() -> None:
    camera = Camerawork(0.0)
    shots(camera, Place(0.0, 1.0, pi / 2), WALKING, 3.0, 0.0)
    assert camera.follow(9000.0, HOME, Pace(), False).y == pytest.approx(-DISTANCE, abs=20)


def test_viewpoints_frame_the_figure_as_they_are_called() -> None:
    there = Place(1.5, 2.0, 0.0)
    seen = {}
    for viewpoint in ("face", "room", "follow"):
        camera = Camerawork(0.0)
        camera.viewpoint = viewpoint
        seen[viewpoint] = shots(camera, there, WALKING, 8.0, 0.0)[-1]
    assert seen["face"] == shot(there.x, there.y, 0.0)
    assert seen["follow"] == shot(there.x, there.y, 1.0)
    assert seen["room"].x == 0.0
    assert seen["room"].y < seen["follow"].y
    assert seen["face"].is_close
    assert not seen["room"].is_close


def test_its_own_eyes_look_where_it_faces() -> None:
    camera = Camerawork(0.0)
    camera.viewpoint = "eyes"
    (seen,) = set(shots(camera, Place(1.0, 2.0, pi), WALKING, 0.5, 0.0))
    assert seen == own_shot(Place(1.0, 2.0, pi))
    assert seen.heading == pytest.approx(pi / 2)  # to the left
    assert seen.x < METRE
    assert not seen.is_close
    assert seen.sees(Place(-2.0, -1.0, 0.0), 1.8)
    camera.viewpoint = "automatic"
    assert not shots(camera, HOME, Pace(), 0.1, 0.5)[-1].own
