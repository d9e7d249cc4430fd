import numpy as np
import pytest
from hypothesis import given
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray
from openrois_body.hearing.voice_frames import SPAN, measure

from tests.support.hearing import RATE, not_speech, voice

TIME = np.arange(SPAN) / RATE


def buzz(hertz: float, amplitude: float = 3000.0) -> NDArray[np.int16]:
    parts = [amplitude / number * np.sin(2 * np.pi * hertz * number * TIME) for number in range(1, 15)]
    return np.asarray(np.rint(np.sum(parts, axis=0)), np.int16)


@pytest.mark.parametrize("hertz", [75.0, 120.0, 200.0, 390.0])
def test_a_voice_has_its_pitch(hertz: float) -> None:
    moment = measure(buzz(hertz))
    assert moment.pitch is not None
    assert 2**moment.pitch == pytest.approx(hertz, rel=0.01)
    assert not moment.pure


def test_noise_and_silence_have_none() -> None:
    assert measure(not_speech()["white noise"][:SPAN]).pitch is None
    silent = measure(np.zeros(SPAN, np.int16))
    assert silent.pitch is None
    assert silent.level < -80


def test_a_tone_is_pure_and_has_its_level() -> None:
    moment = measure(np.rint(32_767 * np.sin(2 * np.pi * 1000 * TIME)).astype(np.int16))
    assert moment.pure
    assert moment.level == pytest.approx(-3.0, abs=0.2)
    assert not measure(voice(0.1)[:SPAN]).pure


@given(arrays.arrays(np.int16, SPAN))
def test_anything_can_be_measured(samples: NDArray[np.int16]) -> None:
    moment = measure(samples)
    assert -100 < moment.level < 3
    assert np.isfinite(moment.shape).all()
    assert moment.pitch is None or 70 < 2**moment.pitch < 410
