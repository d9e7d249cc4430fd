"""What of a stream of findings is told."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_avatar.sensing.changes import Movements, Numbers, Place

HERE = Place(0.0, 1.0, 0.0)


def right(metres: float) -> Place:
    return Place(metres, 1.0, 0.0)


def test_a_place_as_text() -> None:
    assert Place(0.5, 2.0, -math.pi / 2).text == "0.500,2.000,-1.5708"


def test_a_number_is_told_when_it_changes() -> None:
    numbers = Numbers()
    assert [numbers.tells(each) for each in (0, 1, 1, 2, 2, 0, 0)] == [False, True, False, True, False, True, False]


def test_who_begins_to_listen_is_told_the_number_and_who_had_heard_another_one_that_nobody_is_left() -> None:
    numbers = Numbers()
    numbers.begin()
    assert not numbers.tells(0)
    assert numbers.tells(2)
    numbers.begin()
    assert [numbers.tells(each) for each in (2, 2)] == [True, False]
    numbers.begin()
    assert [numbers.tells(each) for each in (0, 0)] == [True, False]
    numbers.begin()
    assert not numbers.tells(0)


def test_movements_that_are_not_far_enough_add_up() -> None:
    movements = Movements()
    told = [movements.tells({"a": right(step / 100)}, step, 50, None) for step in range(12)]
    assert [step for step, tells in enumerate(told) if tells] == [0, 6]


def test_any_movement_is_told_where_nothing_is_set_and_rest_never() -> None:
    movements = Movements()
    assert movements.tells({"a": HERE}, 0.0, None, None)
    assert movements.tells({"a": right(0.001)}, 0.0, None, None)
    assert not movements.tells({"a": right(0.001)}, 9.0, None, None)
    turned = Place(0.001, 1.0, 2.0)
    assert not movements.tells({"a": turned}, 9.0, None, None)


def test_who_comes_and_who_goes_is_told() -> None:
    movements = Movements()
    assert movements.tells({"a": HERE}, 0.0, 1000, None)
    assert movements.tells({"a": HERE, "b": HERE}, 1.0, 1000, None)
    assert movements.tells({"b": HERE}, 2.0, 1000, None)
    assert not movements.tells({}, 3.0, 1000, None)
    assert movements.tells({"b": HERE}, 4.0, 1000, None)


def test_what_comes_too_early_is_told_later_and_only_if_it_is_still_true() -> None:
    movements = Movements()
    assert movements.tells({"a": HERE}, 10.0, 50, 500)
    assert not movements.tells({"a": right(1.0)}, 10.4, 50, 500)
    assert not movements.tells({"a": HERE}, 10.6, 50, 500)
    assert not movements.tells({"a": HERE, "b": HERE}, 10.2, 50, 500)
    assert movements.tells({"a": HERE, "b": HERE}, 10.5, 50, 500)
    assert not movements.tells({}, 10.6, 50, 500)
    assert not movements.tells({"c": HERE}, 10.7, 50, 500)


@pytest.mark.parametrize(("threshold", "interval"), [(0, 0), (80, 300)])
@given(steps=st.lists(st.tuples(st.floats(0, 0.5), st.floats(-1, 1)), max_size=40))
def test_two_that_are_told_are_as_far_apart_as_the_parameters_say(
    threshold: int, interval: int, steps: list[tuple[float, float]]
) -> None:
    movements, now, told = Movements(), 0.0, []
    for pause, x in steps:
        now += pause
        if movements.tells({"a": right(x)}, now, threshold, interval):
            told.append((now, x))
    for (earlier, before), (later, after) in pairwise(told):
        assert later >= earlier + interval / 1000
        assert abs(after - before) * 1000 > threshold
