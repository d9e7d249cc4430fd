"""The refs of persons and faces."""

from openrois_body.sensing.changes import Place
from openrois_body.vision.box import Box
from openrois_body.vision.sighting import Person, Refs


def test_a_person_and_their_face_have_the_same_id() -> None:
    refs, person = Refs("avatar"), Person(7, Box(0, 0, 1, 1), Place(0, 1, 0))
    assert refs.person(person) == "urn:x-rois:def:person:OpenRoIS::avatar/camera/7"
    assert refs.face(person) == "urn:x-rois:def:face:OpenRoIS::avatar/camera/7"


def test_any_name_can_be_in_a_ref() -> None:
    assert Refs("avatar").known("Ann / B:ö") == "urn:x-rois:def:person:OpenRoIS::avatar/enrolled/Ann%20%2F%20B%3A%C3%B6"
