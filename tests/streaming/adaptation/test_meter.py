from dataclasses import dataclass

import pytest
from openrois_streaming.adaptation.meter import LossMeter, RateMeter


@dataclass
class Report:
    highest_sequence: int
    packets_lost: int
    fraction_lost: float = 0.0


def test_a_rate_is_that_of_the_window() -> None:
    meter = RateMeter(100.0)
    assert meter.rate(100.0) == 0
    for n in range(20):
        meter.count(1250, 100 + n / 10)
    assert meter.rate(101.9) == pytest.approx(100_000)
    assert meter.rate(102.5) == pytest.approx(40_000)
    assert meter.rate(110.0) == 0


def test_a_young_meter_does_not_divide_by_a_time_that_was_not() -> None:
    meter = RateMeter(0.0)
    meter.count(1250, 0.0)
    assert meter.rate(0.0) == pytest.approx(100_000)
    assert meter.rate(0.5) == pytest.approx(20_000)


def test_unread_counts_are_dropped() -> None:
    meter = RateMeter(0.0)
    for n in range(1000):
        meter.count(1250, n / 10)
    assert len(meter._counts) == 10
    assert meter.rate(99.9) == pytest.approx(100_000)


def test_first_report_covers_all_packets_before_it() -> None:
    assert LossMeter().add_report(Report(1000, 40, 0.4)) == 0.4


def test_later_ones_count_over_sixty_packets_at_least() -> None:
    meter = LossMeter()
    meter.add_report(Report(1000, 0))
    assert meter.add_report(Report(1030, 3)) is None
    assert meter.add_report(Report(1060, 6)) == pytest.approx(0.1)
    assert meter.add_report(Report(1090, 6)) == pytest.approx(3 / 60)
    assert meter.add_report(Report(1400, 6)) == 0
    assert meter.add_report(Report(1500, 2)) == 0, "duplicates make the count go back"


def test_another_receiver_begins_anew() -> None:
    meter = LossMeter()
    meter.add_report(Report(5000, 100))
    assert meter.add_report(Report(10, 0)) is None
    assert meter.add_report(Report(110, 20)) == pytest.approx(0.2)


def test_earlier_losses_can_be_reset() -> None:
    meter = LossMeter()
    meter.reset()
    assert meter.add_report(Report(1000, 500, 0.9)) is None
    assert meter.add_report(Report(1100, 510)) == pytest.approx(0.1)
