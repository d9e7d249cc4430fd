import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_streaming.source.source import SAMPLE_RATE
from openrois_streaming.testing.clicks import ClickFinder

from tests.support.sounds import bursts


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
