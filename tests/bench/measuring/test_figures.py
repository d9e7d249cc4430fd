import pytest
from openrois_bench.measuring.figures import MICROSECONDS, Percentiles, Throughput, median, medians, slope


def test_percentiles_of_seconds_in_microseconds() -> None:
    waits = Percentiles.of([number / 1000 for number in range(100, 0, -1)], MICROSECONDS)
    assert (waits.count, waits.p50, waits.p95, waits.p99) == (100, 50_000, 95_000, 99_000)
    assert Percentiles.of([0.001], MICROSECONDS).p99 == 1000


def test_percentiles_are_values_that_were_measured() -> None:
    assert Percentiles.of([9.0, 1.0, 5.0]) == Percentiles(count=3, p50=5.0, p95=9.0, p99=9.0)
    assert Percentiles.of([2.0, 1.0]).p50 == 1.0


def test_without_values_there_are_no_percentiles() -> None:
    with pytest.raises(ValueError, match="there are no values to sum up"):
        Percentiles.of([])


def test_the_median_over_rounds_is_that_of_each_figure() -> None:
    rounds = [Percentiles(count=10, p50=p50, p95=p95, p99=30) for p50, p95 in ((1, 9), (2, 7), (9, 8))]
    assert Percentiles.median(rounds) == Percentiles(count=30, p50=2, p95=8, p99=30)
    assert median([1, 2]) == 1.5


def test_throughput_of_one_and_median_over_rounds() -> None:
    one, two = (Throughput.of(10, took, gateway=0.02, adapter=0.03, load=0.01) for took in (2.0, 5.0))
    assert (one.per_second, one.gateway_us, one.adapter_us, one.load_us) == (5, 2000, 3000, 1000)
    assert Throughput.median([one, two]).per_second == 3.5


def test_runs_that_are_alike_have_one_row_of_medians() -> None:
    runs = [
        {"way": way, "viewers": 2, "cpu": cpu, "fps": 30}
        for way, cpu in (("b", 1.0), ("a", 4.0), ("b", 3.0), ("b", 1.5))
    ]
    assert medians(runs, by=("way", "viewers"), of=("cpu", "fps")) == [
        {"way": "b", "viewers": 2, "cpu": 1.5, "fps": 30, "runs": 3},
        {"way": "a", "viewers": 2, "cpu": 4.0, "fps": 30, "runs": 1},
    ]


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
