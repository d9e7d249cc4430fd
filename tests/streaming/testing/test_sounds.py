import pytest
from openrois_streaming.source.source import SAMPLE_RATE
from openrois_streaming.testing.sounds import HeardClick, SoundLog

from tests.support.sounds import bursts

BLOCK = SAMPLE_RATE // 50
EPOCH = 1_800_000_000.0


def test_nothing_was_heard() -> None:
    figures = SoundLog(5.0).figures(7.0)
    assert (figures.seconds, figures.heard, figures.clicks, figures.delay) == (2.0, 0.0, 0, None)


def test_markers_tell_how_late_the_sound_is() -> None:
    # Of sound whose first sample is of a quarter past the second, and that comes 80 ms late.
    sound = bursts(SAMPLE_RATE * 3 // 4, SAMPLE_RATE * 7 // 4)
    log = SoundLog(0.0)
    clicks: list[HeardClick] = []
    for start in range(0, len(sound), BLOCK):
        captured = EPOCH + 0.25 + start / SAMPLE_RATE
        clicks += log.add(sound[start : start + BLOCK], captured + 0.01, captured + 0.08)
    assert [click.second for click in clicks] == [EPOCH + 1, EPOCH + 2]
    assert [click.told for click in clicks] == pytest.approx([0.01, 0.01], abs=1e-3)
    figures = log.figures(2.0)
    assert (figures.heard, figures.clicks) == (pytest.approx(2.0), 2)
    assert figures.delay is not None
    assert (figures.delay.p50, figures.delay.longest) == pytest.approx((0.08, 0.08), abs=1e-3)
    assert (log.blocks, log.clicks) == (100, 2)
    log.restart(2.0)
    assert log.figures(3.0).delay is None
    assert log.figures(3.0).heard == 0.0
    assert (log.blocks, log.clicks) == (100, 2)
