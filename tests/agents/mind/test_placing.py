"""Places on a floor, as an agent is told of them."""

from math import pi

import pytest
from openrois_agents.mind.placing import Place, before_person, place_of, places_by_name, side_of


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("1.5,-2,0.5", Place(1.5, -2.0, 0.5)),
        ("1,2", Place(1.0, 2.0)),
        ("", None),
        ("1", None),
        ("1,2,3,4", None),
        ("1,x", None),
        (None, None),
    ],
)
def test_a_place_is_read_or_left_out(text: object, place: Place | None) -> None:
    assert place_of(text) == place


def test_what_has_no_place_is_left_out() -> None:
    assert places_by_name({"plant": "1,2,0", "ghost": "everywhere"}) == {"plant": Place(1.0, 2.0)}
    assert places_by_name(None) == {}


def test_a_body_comes_from_where_it_is_and_looks_at_the_person() -> None:
    target = before_person(Place(3.0, 0.0), Place(0.0, 0.0))
    assert target == pytest.approx((2.1, 0.0, 0.0))
    # Where its own place is not known, it comes from where the person looks.
    assert before_person(Place(3.0, 0.0, pi / 2), None) == pytest.approx((3.0, 0.9, -pi / 2))


def test_a_body_that_is_with_the_person_stays() -> None:
    assert before_person(Place(1.0, 0.0), Place(0.0, 0.0)) is None


@pytest.mark.parametrize(
    ("thing", "side"),
    [
        (Place(2.0, 0.0), "before me"),
        (Place(0.0, 2.0), "to my left"),
        (Place(0.0, -2.0), "to my right"),
        (Place(-2.0, 0.1), "behind me"),
        (Place(-2.0, -0.1), "behind me"),
    ],
)
def test_a_thing_is_on_a_side_as_the_body_sees_it(thing: Place, side: str) -> None:
    assert side_of(thing, Place(0.0, 0.0)) == side
