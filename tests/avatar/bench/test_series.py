import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_avatar.bench.series import Series, percentile


def test_a_series_says_what_is_typical_and_what_is_rare() -> None:
    series = Series.of([9.0, 1.0, 5.0])
    assert (series.count, series.median, series.p95) == (3, 5.0, 9.0)
    assert series.values == (9.0, 1.0, 5.0)


def test_without_values_there_is_nothing_to_say() -> None:
    with pytest.raises(ValueError, match="nothing was measured"):
        Series.of([])


@pytest.mark.parametrize(("share", "expected"), [(0.05, 1), (0.5, 10), (0.95, 19), (0.951, 20), (1.0, 20)])
def test_a_percentile_is_one_of_the_values(share: float, expected: float) -> None:
    assert percentile(range(20, 0, -1), share) == expected


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=40), st.floats(0.01, 1))
def test_so_many_values_do_not_exceed_a_percentile_and_it_is_the_smallest_such(
    values: list[float], share: float
) -> None:
    found = percentile(values, share)
    assert sum(value <= found for value in values) >= share * len(values)
    assert sum(value < found for value in values) < share * len(values)
