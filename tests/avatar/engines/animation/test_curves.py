import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_avatar.engines.animation.curves import Curve, settling, settling_speed, smooth


def test_smooth_rests_at_both_ends() -> None:
    assert [smooth(value) for value in (-1.0, 0.0, 0.5, 1.0, 2.0)] == [0.0, 0.0, 0.5, 1.0, 1.0]
    assert smooth(0.01) < 0.001
    assert smooth(0.99) > 0.999


def test_a_curve_goes_through_its_keys_and_keeps_its_ends() -> None:
    curve = Curve((0.0, 0.0), (1.0, 2.0), (3.0, -1.0), (4.0, 0.0))
    assert [curve(time) for time in (-5.0, 0.0, 1.0, 3.0, 4.0, 9.0)] == pytest.approx([0, 0, 2, -1, 0, 0])


def test_a_curve_passes_a_key_on_its_way_without_stopping() -> None:
    curve = Curve((0.0, 0.0), (1.0, 1.0), (2.0, 2.0))
    assert curve(1.01) - curve(0.99) == pytest.approx(0.02, rel=0.05)


def test_a_curve_rests_at_its_turning_points_and_ends() -> None:
    curve = Curve((0.0, 0.0), (1.0, 1.0), (2.0, 0.0))
    for time in (0.0, 1.0, 2.0):
        assert abs(curve(time + 0.005) - curve(time - 0.005)) < 1e-3


@settings(max_examples=40)
@given(st.lists(st.tuples(st.floats(0.05, 2), st.floats(-3, 3)), min_size=2, max_size=8))
def test_a_curve_never_overshoots_a_key(steps: list[tuple[float, float]]) -> None:
    keys, time = [], 0.0
    for pause, value in steps:
        time += pause
        keys.append((time, value))
    curve = Curve(*keys)
    for (start, first), (end, second) in itertools.pairwise(keys):
        for part in range(21):
            value = curve(start + (end - start) * part / 20)
            assert min(first, second) - 1e-9 <= value <= max(first, second) + 1e-9


def test_a_spring_starts_where_it_was_with_the_speed_it_had_and_comes_to_rest() -> None:
    assert settling(0.5, -2.0, 9.0, 0.0) == 0.5
    assert settling_speed(0.5, -2.0, 9.0, 0.0) == -2.0
    assert abs(settling(0.5, -2.0, 9.0, 1.2)) < 0.001


def test_the_speed_of_a_spring_is_the_slope_of_its_way() -> None:
    slope = (settling(1.0, 3.0, 5.0, 0.301) - settling(1.0, 3.0, 5.0, 0.299)) / 0.002
    assert settling_speed(1.0, 3.0, 5.0, 0.3) == pytest.approx(slope, abs=1e-4)
