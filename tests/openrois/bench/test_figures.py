from openrois.bench.figures import Throughput, Waits, median


def test_waits_are_summed_up_in_microseconds() -> None:
    waits = Waits.of([number / 1000 for number in range(100, 0, -1)])
    assert (waits.count, waits.p50, waits.p95, waits.p99) == (100, 50_000, 95_000, 99_000)
    assert Waits.of([0.001]).p99 == 1000


def test_the_median_over_rounds_is_that_of_each_figure() -> None:
    rounds = [Waits(count=10, p50=p50, p95=p95, p99=30) for p50, p95 in ((1, 9), (2, 7), (9, 8))]
    assert Waits.median(rounds) == Waits(count=30, p50=2, p95=8, p99=30)
    assert median([1, 2]) == 1.5


def test_what_one_of_many_took_and_the_median_over_rounds() -> None:
    one, two = (Throughput.of(10, took, gateway=0.02, adapter=0.03, load=0.01) for took in (2.0, 5.0))
    assert (one.per_second, one.gateway_us, one.adapter_us, one.load_us) == (5, 2000, 3000, 1000)
    assert Throughput.median([one, two]).per_second == 3.5
