"""Tracks of faces from picture to picture."""

from openrois_body.vision.box import Box, Face, Motion
from openrois_body.vision.tracks import FACE_MEMORY, MAX_TRACKS, PERSON_MEMORY, Tracks


def face(x: float, y: float = 0.4, roll: float = 0.0) -> Face:
    return Face(Box(x - 0.05, y - 0.05, 0.1, 0.1), roll)


def followed(*faces: Face, until: float = 0.3) -> Tracks:
    """Tracks of faces that were found in four pictures."""
    tracks = Tracks()
    for step in range(4):
        tracks.update(faces, until - 0.1 * (3 - step))
    return tracks


def numbers(tracks: Tracks) -> list[int]:
    return [track.number for track in tracks.confirmed]


def test_a_face_counts_when_it_was_found_three_times() -> None:
    tracks = Tracks()
    for expected in ([], [], [1], [1]):
        tracks.update([face(0.5)], 0.0)
        assert numbers(tracks) == expected


def test_face_found_once_is_soon_dropped() -> None:
    tracks = Tracks()
    tracks.update([face(0.5)], 0.0)
    tracks.update([], 0.4)
    assert tracks.numbers == [1]
    tracks.update([], 0.6)
    assert tracks.numbers == []


def test_a_person_stays_for_a_while_after_the_face_is_gone() -> None:
    tracks = followed(face(0.5))
    (track,) = tracks.confirmed
    assert track.shows_face(0.3 + FACE_MEMORY - 0.01)
    assert not track.shows_face(0.3 + FACE_MEMORY + 0.01)
    tracks.update([], 0.3 + PERSON_MEMORY - 0.01)
    assert numbers(tracks) == [1]
    tracks.update([], 0.3 + PERSON_MEMORY + 0.01)
    assert tracks.known == []


def test_two_faces_keep_their_numbers_in_any_order_and_a_returning_face_gets_a_new_one() -> None:
    tracks = followed(face(0.2), face(0.8))
    tracks.update([face(0.81), face(0.21)], 0.4)
    assert [round(track.face.box.centre[0], 1) for track in tracks.confirmed] == [0.2, 0.8]
    assert numbers(tracks) == [1, 2]
    tracks.update([], 9.0)
    for _ in range(3):
        tracks.update([face(0.2)], 9.1)
    assert numbers(tracks) == [3]


def test_motion_is_followed_while_nothing_is_found() -> None:
    tracks = followed(face(0.2), face(0.8))
    tracks.move([Motion(0.3, 0.0, 1.0, 0.1), None])
    tracks.update([face(0.5)], 0.5)
    first, second = tracks.confirmed
    assert (first.number, first.found_at, second.found_at) == (1, 0.5, 0.3)
    assert round(first.face.box.centre[0], 6) == 0.5
    assert 0.05 < first.face.roll < 0.1


def test_second_box_on_the_same_face_makes_no_track() -> None:
    tracks = followed(face(0.5))
    tracks.update([face(0.5), face(0.53)], 0.4)
    assert tracks.numbers == [1]


def test_so_many_are_followed_and_no_more() -> None:
    tracks = Tracks()
    tracks.update([face(0.02 + 0.1 * step, row) for step in range(10) for row in (0.2, 0.8)], 0.0)
    assert len(tracks.known) == MAX_TRACKS


def test_a_successor_gives_other_numbers() -> None:
    tracks = followed(face(0.5)).successor()
    tracks.update([face(0.5)], 0.0)
    assert tracks.numbers == [2]
