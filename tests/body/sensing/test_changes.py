"""Which findings of a stream are notified."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_body.sensing.changes import Movements, Numbers, Place

HERE = Place(0.0, 1.0, 0.0)


def right(metres: float) -> Place:
    return Place(metres, 1.0, 0.0)


def test_a_place_as_text() -> None:
    assert Place(0.5, 2.0, -math.pi / 2).text == "0.500,2.000,-1.5708"


def test_a_number_is_told_when_it_changes() -> None:
    numbers = Numbers()
    assert [numbers.is_news(each) for each in (0, 1, 1, 2, 2, 0, 0)] == [False, True, False, True, False, True, False]


def test_number_is_announced_again_for_a_new_subscriber_and_zero_after_another_number() -> None:
    numbers = Numbers()
    numbers.begin()
    assert not numbers.is_news(0)
    assert numbers.is_news(2)
    numbers.begin()
    assert [numbers.is_news(each) for each in (2, 2)] == [True, False]
    numbers.begin()
    assert [numbers.is_news(each) for each in (0, 0)] == [True, False]
    numbers.begin()
    assert not numbers.is_news(0)


def test_movements_that_are_not_far_enough_add_up() -> None:
    movements = Movements()
    told = [movements.is_news({"a": right(step / 100)}, step, 50, None) for step in range(12)]
    assert [step for step, tells in enumerate(told) if tells] == [0, 6]


def test_any_movement_is_told_where_nothing_is_set_and_rest_never() -> None:
    movements = Movements()
    assert movements.is_news({"a": HERE}, 0.0, None, None)
    assert movements.is_news({"a": right(0.001)}, 0.0, None, None)
    assert not movements.is_news({"a": right(0.001)}, 9.0, None, None)
    turned = Place(0.001, 1.0, 2.0)
    assert not movements.is_news({"a": turned}, 9.0, None, None)


def test_appearance_and_disappearance_are_announced() -> None:
    movements = Movements()
    assert movements.is_news({"a": HERE}, 0.0, 1000, None)
    assert movements.is_news({"a": HERE, "b": HERE}, 1.0, 1000, None)
    assert movements.is_news({"b": HERE}, 2.0, 1000, None)
    assert not movements.is_news({}, 3.0, 1000, None)
    assert movements.is_news({"b": HERE}, 4.0, 1000, None)


def test_early_movement_is_announced_later_only_if_it_still_differs() -> None:
    movements = Movements()
    assert movements.is_news({"a": HERE}, 10.0, 50, 500)
    assert not movements.is_news({"a": right(1.0)}, 10.4, 50, 500)
    assert not movements.is_news({"a": HERE}, 10.6, 50, 500)
    assert not movements.is_news({"a": HERE, "b": HERE}, 10.2, 50, 500)
    assert movements.is_news({"a": HERE, "b": HERE}, 10.5, 50, 500)
    assert not movements.is_news({}, 10.6, 50, 500)
    assert not movements.is_news({"c": HERE}, 10.7, 50, 500)


@pytest.mark.parametrize(("threshold", "interval"), [(0, 0), (80, 300)])
@given(steps=st.lists(st.tuples(st.floats(0, 0.5), st.floats(-1, 1)), max_size=40))
def test_two_that_are_told_are_as_far_apart_as_the_parameters_say(
    threshold: int, interval: int, steps: list[tuple[float, float]]
) -> None:
    movements, now, told = Movements(), 0.0, []
    for pause, x in steps:
        now += pause
        if movements.is_news({"a": right(x)}, now, threshold, interval):
            told.append((now, x))
    for (earlier, before), (later, after) in pairwise(told):
        assert later >= earlier + interval / 1000
        assert abs(after - before) * 1000 > threshold
