"""Where the persons are that the robot detects, and which of them was there before."""

from math import atan2, hypot, pi

import pytest
from openrois_robots.kachaka.persons import DetectedRefs, Found, Lens, PersonTracks, is_located

LENS = Lens(1280, 720, 800.0, 640.0)


def found(middle: float = 640.0, distance: float = 2.0, score: float = 0.9) -> Found:
    return Found(middle - 50, 100, 100, 400, score, distance)


def test_a_person_in_the_middle_is_straight_ahead() -> None:
    (person,) = PersonTracks().update([found()], LENS, 0.0)
    assert (person.place.x, person.place.y) == pytest.approx((0.0, 2.0))
    assert person.place.th == pytest.approx(-pi / 2), "as if it looked at the camera"
    assert person.box == pytest.approx((590 / 1280, 100 / 720, 100 / 1280, 400 / 720))
    assert not person.face


def test_a_person_on_the_right_is_on_the_right() -> None:
    (person,) = PersonTracks().update([found(1040.0)], LENS, 0.0)
    assert hypot(person.place.x, person.place.y) == pytest.approx(2.0)
    assert atan2(person.place.x, person.place.y) == pytest.approx(atan2(400, 800))


def test_a_distance_that_was_not_measured_is_no_place() -> None:
    (person,) = PersonTracks().update([found(distance=0.0)], LENS, 0.0)
    assert person.place == pytest.approx((0.0, 0.0, -pi / 2))
    assert not is_located(person)
    assert is_located(*PersonTracks().update([found()], LENS, 0.0))


@pytest.mark.parametrize("distance", [float("nan"), float("inf"), -1.0])
def test_a_distance_that_is_none_was_not_measured(distance: float) -> None:
    (person,) = PersonTracks().update([found(distance=distance)], LENS, 0.0)
    assert not is_located(person)


def test_there_are_no_more_persons_than_can_be_told() -> None:
    tracks = PersonTracks()
    for turn in range(3):
        crowd = [found(distance=1.0 + turn * 500 + each) for each in range(200)]
        assert len(tracks.update(crowd, LENS, turn * 0.1)) == 50


def test_a_person_keeps_its_number_while_it_moves_and_others_get_their_own() -> None:
    tracks = PersonTracks()
    first = tracks.update([found(400.0), found(900.0)], LENS, 0.0)
    assert [each.number for each in first] == [1, 2]
    second = tracks.update([found(930.0), found(430.0)], LENS, 0.2)
    assert [each.number for each in second] == [1, 2], "by their places, not their order"
    assert second[0].place.x < second[1].place.x
    third = tracks.update([found(430.0), found(930.0), found(640.0, 5.0)], LENS, 0.4)
    assert [each.number for each in third] == [1, 2, 3]


def test_a_person_that_is_missed_for_a_moment_is_still_there_and_gone_after_a_second() -> None:
    tracks = PersonTracks()
    tracks.update([found()], LENS, 0.0)
    assert len(tracks.update([], LENS, 0.9)) == 1
    assert tracks.update([], LENS, 1.1) == ()
    assert tracks.update([found()], LENS, 1.2)[0].number == 2


def test_doubtful_detections_do_not_count() -> None:
    assert PersonTracks().update([found(score=0.4)], LENS, 0.0) == ()


def test_cleared_tracks_give_no_number_twice() -> None:
    tracks = PersonTracks()
    tracks.update([found()], LENS, 0.0)
    tracks.clear()
    assert tracks.update([found()], LENS, 0.1)[0].number == 2


def test_a_lens_that_is_not_told_sees_sixty_degrees() -> None:
    lens = Lens.usual(1280, 720)
    assert atan2(640, lens.focal) == pytest.approx(pi / 6)


def test_their_refs_are_not_those_of_our_own_vision() -> None:
    (person,) = PersonTracks().update([found()], LENS, 0.0)
    assert DetectedRefs("kachaka").person(person) == "urn:x-rois:def:person:OpenRoIS::kachaka/detected/1"
