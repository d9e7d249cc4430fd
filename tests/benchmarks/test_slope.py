import pytest

from benchmarks.soak.slope import slope


def test_a_line_has_its_slope_whatever_a_few_samples_say() -> None:
    samples = [(float(second), 100 + 0.5 * second) for second in range(50)]
    assert slope(samples) == pytest.approx(0.5)
    samples[7:12] = [(second, 10_000.0) for second, _ in samples[7:12]]
    assert slope(samples) == pytest.approx(0.5, rel=0.05)


def test_very_many_samples_are_thinned_out() -> None:
    assert slope([(float(second), 2.0 * second) for second in range(2000)]) == pytest.approx(2.0)


def test_one_moment_has_no_slope() -> None:
    with pytest.raises(ValueError, match="two moments"):
        slope([(1.0, 5.0), (1.0, 6.0)])
