import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray
from openrois_streaming.source.loudness import FLOOR, SILENCE, Level, LevelMeter

SINE = np.sin(2 * np.pi * np.arange(48_000) / 48)


def level_of(*blocks: NDArray[np.int16]) -> Level:
    meter = LevelMeter()
    for block in blocks:
        meter.add(block)
    return meter.read()


@pytest.mark.parametrize(("scale", "level"), [(32_767, (-3.0, 0.0)), (3_277, (-23.0, -20.0)), (0, SILENCE)])
def test_a_sine_has_its_level(scale: float, level: Level) -> None:
    sine = np.round(SINE * scale).astype(np.int16)
    assert level_of(sine) == level
    assert level_of(*np.split(sine, 100)) == level
    assert level_of(np.column_stack([sine, sine])) == level


def test_the_greatest_negative_value_counts() -> None:
    assert level_of(np.array([-32_768], np.int16)) == (0.0, 0.0)


def test_each_look_begins_anew() -> None:
    meter = LevelMeter()
    assert meter.read() == SILENCE
    meter.add(np.zeros((0, 2), np.int16))
    meter.add(np.full((480, 1), 1000, np.int16))
    assert meter.read().peak == -30.3
    assert meter.read() == SILENCE


@given(arrays.arrays(np.int16, st.integers(0, 500)))
def test_a_level_is_always_between_silence_and_full_scale(samples: NDArray[np.int16]) -> None:
    rms, peak = level_of(samples)
    assert FLOOR <= rms <= peak <= 0
