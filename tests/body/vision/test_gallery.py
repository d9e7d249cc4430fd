"""Identification of enrolled persons."""

import numpy as np
from openrois_body.vision.gallery import MAX_ENROLLED, Gallery, Likeness, Opinion


def likeness(*values: float) -> Likeness:
    return np.array(values, np.float32)


ANN, BEN = likeness(0.0, 1.0), likeness(1.0, 0.0)


def test_nearest_person_within_the_limit_is_identified() -> None:
    gallery = Gallery()
    gallery.enrol("Ben", [BEN, likeness(0.9, 0.0)])
    gallery.enrol("Ann", [ANN])
    assert gallery.names == ("Ann", "Ben")
    assert gallery.identify(likeness(0.1, 0.9), 0.5) == "Ann"
    assert gallery.identify(likeness(0.8, 0.1), 0.5) == "Ben"
    assert gallery.identify(likeness(5.0, 5.0), 0.5) is None


def test_second_enrolment_replaces_the_first_and_forgotten_person_is_not_identified() -> None:
    gallery = Gallery()
    gallery.enrol("Ann", [ANN])
    gallery.enrol("Ann", [BEN])
    assert gallery.identify(BEN, 0.1) == "Ann"
    assert gallery.identify(ANN, 0.1) is None
    assert gallery.remove_person("Ann")
    assert not gallery.remove_person("Ann")
    assert gallery.identify(BEN, 0.1) is None


def test_gallery_is_full_at_its_limit() -> None:
    gallery = Gallery()
    for number in range(MAX_ENROLLED):
        assert not gallery.is_full
        gallery.enrol(str(number), [ANN])
    assert gallery.is_full


def test_several_looks_have_to_agree() -> None:
    opinion, told = Opinion(), list[str | None]()
    assert opinion.name is None
    for look in ("Ann", "Ann", "Ben", "Ann", None, None, None):
        opinion.add_vote(look)
        told.append(opinion.name)
    assert told == [None, None, None, "Ann", "Ann", None, None]
