import pytest
from openrois_streaming.testing.lipsync import LipSync

pytestmark = pytest.mark.extra(name="streaming")


def test_nothing_to_compare() -> None:
    sync = LipSync()
    assert sync.figures() is None
    sync.add_sound(100.0, 0.1)
    assert sync.figures() is None
    sync.add_picture(90.0, 0.1)
    assert sync.figures() is None, "the picture of that second is still to come"
    sync.add_picture(100.2, 0.1)
    assert sync.figures() is None, "no picture is near enough"


@pytest.mark.parametrize("sound_first", [True, False])
def test_the_error_is_what_sound_is_later_than_the_nearest_picture(sound_first: bool) -> None:
    sync = LipSync()
    if sound_first:
        sync.add_sound(100.0, 0.09)
    for captured, delay in ((99.97, 0.5), (99.999, 0.02), (100.03, 0.6)):
        sync.add_picture(captured, delay)
    if not sound_first:
        sync.add_sound(100.0, 0.09)
    figures = sync.figures()
    assert figures is not None
    assert (figures.count, figures.drift) == (1, 0.0)
    assert (figures.median, figures.p95, figures.worst) == pytest.approx((0.07, 0.07, 0.07))


def test_errors_go_both_ways_and_a_drift_shows() -> None:
    sync = LipSync()
    for number in range(101):
        sync.add_picture(1000.0 + number, 0.05)
        sync.add_sound(1000.0 + number, 0.05 - 0.010 + number * 0.0002)
    figures = sync.figures()
    assert figures is not None
    assert figures.count == 101
    assert figures.median == pytest.approx(0.0)
    assert figures.p95 == pytest.approx(0.0096, abs=0.0003)
    assert figures.worst == pytest.approx(0.01)
    assert figures.drift == pytest.approx(0.0002)
    sync.restart()
    assert sync.figures() is None


def test_marker_of_before_a_restart_is_not_counted() -> None:
    sync = LipSync()
    sync.add_picture(99.98, 0.02)
    sync.add_sound(100.0, 0.09)
    sync.restart()
    sync.add_picture(100.01, 0.02)
    assert sync.figures() is None
    sync.add_sound(101.0, 0.09)
    sync.add_picture(101.0, 0.02)
    assert sync.figures() is not None
