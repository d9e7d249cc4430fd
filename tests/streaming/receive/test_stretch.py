import numpy as np
import pytest
from openrois_streaming.receive.stretch import LONGEST_PERIOD, Samples, longer, shorter

from tests.support.playout import hum

PERIOD = 240


def noise(samples: int) -> Samples:
    return np.random.default_rng(1).integers(-9000, 9000, (samples, 1)).astype(np.int16)


def test_one_period_is_left_out() -> None:
    sound = hum(0, 1440)
    short = shorter(sound, 300)
    assert len(short) == 1440 - PERIOD
    # The sound is periodic: without one period it is the same.
    assert np.abs(short.astype(int) - hum(0, len(short))).max() <= 2


def test_one_period_is_repeated() -> None:
    long = longer(hum(0, 1440), 300)
    assert len(long) == 1440 + PERIOD
    assert np.abs(long.astype(int) - hum(0, len(long))).max() <= 2


def test_sound_without_period_is_unchanged() -> None:
    sound = noise(1440)
    assert shorter(sound, 300) is sound


def test_but_not_if_it_has_to_be_shorter() -> None:
    assert 1440 - 300 <= len(shorter(noise(1440), 300, force=True)) < 1440


def test_quiet_parts_are_shortened_by_all_that_is_wanted() -> None:
    assert len(shorter(np.zeros((1440, 2), np.int16), 10_000)) == 1440 - LONGEST_PERIOD


@pytest.mark.parametrize(("samples", "most"), [(1440, 119), (239, 1000), (0, 1000)])
def test_too_short_sound_is_unchanged(samples: int, most: int) -> None:
    sound = hum(0, samples)
    assert shorter(sound, most) is sound
    assert longer(sound, most) is sound


def test_an_odd_length_is_no_problem() -> None:
    for samples in range(240, 260):
        assert len(longer(hum(0, samples), 480)) > samples


def test_half_silence_is_no_problem() -> None:
    sound = hum(0, 960)
    sound[:700] = 0
    assert len(shorter(sound, 480, force=True)) < 960
