"""Who is known by face."""

import numpy as np
from openrois_avatar.vision.gallery import MAX_ENROLLED, Gallery, Likeness, Opinion


def likeness(*values: float) -> Likeness:
    return np.array(values, np.float32)


ANN, BEN = likeness(0.0, 1.0), likeness(1.0, 0.0)


def test_the_nearest_within_the_limit_is_who_it_is() -> None:
    gallery = Gallery()
    gallery.enrol("Ben", [BEN, likeness(0.9, 0.0)])
    gallery.enrol("Ann", [ANN])
    assert gallery.names == ("Ann", "Ben")
    assert gallery.who(likeness(0.1, 0.9), 0.5) == "Ann"
    assert gallery.who(likeness(0.8, 0.1), 0.5) == "Ben"
    assert gallery.who(likeness(5.0, 5.0), 0.5) is None


def test_who_is_enrolled_again_is_as_they_look_now_and_who_is_forgotten_is_nobody() -> None:
    gallery = Gallery()
    gallery.enrol("Ann", [ANN])
    gallery.enrol("Ann", [BEN])
    assert gallery.who(BEN, 0.1) == "Ann"
    assert gallery.who(ANN, 0.1) is None
    assert gallery.forget("Ann")
    assert not gallery.forget("Ann")
    assert gallery.who(BEN, 0.1) is None


def test_it_is_full_some_time() -> None:
    gallery = Gallery()
    for number in range(MAX_ENROLLED):
        assert not gallery.is_full
        gallery.enrol(str(number), [ANN])
    assert gallery.is_full


def test_several_looks_have_to_agree() -> None:
    opinion, told = Opinion(), list[str | None]()
    assert opinion.name is None
    for look in ("Ann", "Ann", "Ben", "Ann", None, None, None):
        opinion.take(look)
        told.append(opinion.name)
    assert told == [None, None, None, "Ann", "Ann", None, None]
