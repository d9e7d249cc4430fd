import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_streaming.source.source import SAMPLE_RATE
from openrois_streaming.testing.sounds import ClickFinder, HeardClick, SoundLog

from tests.support.sounds import bursts

pytestmark = pytest.mark.extra(name="streaming")

BLOCK = SAMPLE_RATE // 50
EPOCH = 1_800_000_000.0


def test_no_sound_gives_empty_figures() -> None:
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


def found(sound: NDArray[np.int16], block: int) -> list[int]:
    finder = ClickFinder()
    return [
        start + position
        for start in range(0, len(sound), block)
        for position in finder.find(sound[start : start + block])
    ]


@pytest.mark.parametrize("block", [7, 48, 480, 960, 96_000])
@pytest.mark.parametrize("start", [0, 4_800, 30_001, 40_047])
def test_a_burst_is_found_to_a_millisecond_however_the_sound_is_cut(start: int, block: int) -> None:
    (position,) = found(bursts(start), block)
    assert abs(position - start) <= SAMPLE_RATE // 1000


def test_each_burst_is_found_once() -> None:
    positions = found(bursts(1_000, 49_000), 960)
    assert [round(position / 1000) for position in positions] == [1, 49]


def test_a_burst_with_a_hole_is_one() -> None:
    sound = bursts(10_000)
    sound[10_500:11_000] = 0
    assert len(found(sound, 960)) == 1


def test_silence_and_quiet_sounds_are_none() -> None:
    assert found(bursts(), 960) == []
    assert found(bursts(9_600, amplitude=4_000), 960) == []
    assert ClickFinder().find(np.empty(0, np.int16)) == []
