import pytest
from openrois_streaming.testing.lipsync import LipSync


def test_nothing_to_compare() -> None:
    sync = LipSync()
    assert sync.figures() is None
    sync.heard(100.0, 0.1)
    assert sync.figures() is None
    sync.saw(90.0, 0.1)
    assert sync.figures() is None, "the picture of that second is still to come"
    sync.saw(100.2, 0.1)
    assert sync.figures() is None, "no picture is near enough"


@pytest.mark.parametrize("sound_first", [True, False])
def test_the_error_is_what_sound_is_later_than_the_nearest_picture(sound_first: bool) -> None:
    sync = LipSync()
    if sound_first:
        sync.heard(100.0, 0.09)
    for captured, delay in ((99.97, 0.5), (99.999, 0.02), (100.03, 0.6)):
        sync.saw(captured, delay)
    if not sound_first:
        sync.heard(100.0, 0.09)
    figures = sync.figures()
    assert figures is not None
    assert (figures.count, figures.drift) == (1, 0.0)
    assert (figures.median, figures.p95, figures.worst) == pytest.approx((0.07, 0.07, 0.07))


def test_errors_go_both_ways_and_a_drift_shows() -> None:
    sync = LipSync()
    for number in range(101):
        sync.saw(1000.0 + number, 0.05)
        sync.heard(1000.0 + number, 0.05 - 0.010 + number * 0.0002)
    figures = sync.figures()
    assert figures is not None
    assert figures.count == 101
    assert figures.median == pytest.approx(0.0)
    assert figures.p95 == pytest.approx(0.0096, abs=0.0003)
    assert figures.worst == pytest.approx(0.01)
    assert figures.drift == pytest.approx(0.0002)
    sync.restart()
    assert sync.figures() is None
