import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_streaming.testing.delays import Delays, percentile

pytestmark = pytest.mark.extra(name="streaming")


def test_nothing_was_measured() -> None:
    assert Delays.of([]) is None


def test_percentiles_are_values_that_were_measured() -> None:
    delays = Delays.of(number / 100 for number in reversed(range(1, 101)))
    assert delays == Delays(count=100, p50=0.5, p95=0.95, p99=0.99, longest=1.0)
    assert Delays.of([3.0]) == Delays(1, 3.0, 3.0, 3.0, 3.0)


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
