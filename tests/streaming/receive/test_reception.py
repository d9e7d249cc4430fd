import pytest
from openrois_streaming.receive.reception import Reception, SourceReception


def received(sequences: list[int], *, spacing: float = 0.02) -> SourceReception:
    reception = SourceReception(48_000)
    for sequence in sequences:
        reception.add(sequence, sequence * 960, 5 + sequence * spacing)
    return reception


def test_nothing_is_reported_of_nothing() -> None:
    reception = SourceReception(90_000)
    assert reception.report(1.0) is None
    assert reception.lost == 0


def test_everything_came() -> None:
    report = received(list(range(65_530, 65_580))).report(9.0)
    assert report == Reception(0, 0, 65_579, 0, 0, 0)


def test_losses_are_counted_from_the_start_and_since_the_last_report() -> None:
    reception = received([10, 11, 13, 14])
    first = reception.report(1.0)
    assert first is not None
    assert (first.packets_lost, first.fraction_lost) == (1, 256 // 5)
    for sequence in (15, 16, 17, 18):
        reception.add(sequence, sequence * 960, 5 + sequence * 0.02)
    second = reception.report(2.0)
    assert second is not None
    assert (second.packets_lost, second.fraction_lost) == (1, 0)
    third = reception.report(3.0)
    assert third is not None
    assert third.fraction_lost == 0


def test_repeated_packets_count_as_the_standard_has_it() -> None:
    reception = received([10, 11, 11, 11])
    report = reception.report(1.0)
    assert report is not None
    assert (report.packets_lost, report.fraction_lost) == (-2, 0)


def test_the_bounds_of_the_fields() -> None:
    reception = received([0])
    reception.add(1 << 25, 0, 6.0)
    reception.reported(0x1234_5678_9ABC_DEF0, 5.0)
    report = reception.report(5.0 + 100_000)
    assert report is not None
    assert report.fraction_lost == 255
    assert report.packets_lost == (1 << 23) - 1
    assert report.delay == 0xFFFFFFFF
    assert report.last_report == 0x5678_9ABC


def test_how_long_ago_the_sender_reported() -> None:
    reception = received([1])
    reception.reported(0, 5.0)
    report = reception.report(5.5)
    assert report is not None
    assert report.delay == 32_768


def test_jitter_is_smoothed() -> None:
    assert received(list(range(200))).jitter_seconds == pytest.approx(0, abs=1e-9)
    # Every interval is 1 ms too long.
    assert received(list(range(200)), spacing=0.021).jitter_seconds == pytest.approx(0.001, rel=0.01)


def test_the_packets_of_one_picture_are_no_jitter() -> None:
    reception = SourceReception(90_000)
    for picture in range(50):
        for part in range(4):
            reception.add(4 * picture + part, 3000 * picture, picture / 30 + part * 0.005)
    assert reception.jitter_seconds == pytest.approx(0, abs=1e-9)
