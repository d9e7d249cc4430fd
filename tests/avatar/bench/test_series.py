import pytest
from openrois_avatar.bench.series import Series


def test_a_series_says_what_is_typical_and_what_is_rare() -> None:
    series = Series.of([9.0, 1.0, 5.0])
    assert (series.count, series.median, series.p95) == (3, 5.0, 9.0)
    assert series.values == (9.0, 1.0, 5.0)


def test_without_values_there_is_nothing_to_say() -> None:
    with pytest.raises(ValueError, match="nothing was measured"):
        Series.of([])
