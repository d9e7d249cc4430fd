import math

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.hearing.bearing import SOUND_SPEED, WINDOW, BearingFinder, is_stereo

from tests.support.hearing import not_speech, stereo_48k, voice

DISTANCE = 0.15


def heard_from(bearing: float, sound: NDArray[np.int16], noise: float = 20.0) -> NDArray[np.int16]:
    """One channel of 48 kHz, as two microphones at `DISTANCE` hear it from `bearing`, each with noise of its own."""
    late = math.sin(bearing) * DISTANCE / SOUND_SPEED * 48_000
    spectrum = np.fft.rfft(sound)
    turn = np.exp(-2j * np.pi * np.fft.rfftfreq(len(sound)) * late)
    left = np.fft.irfft(spectrum * turn, len(sound))
    random = np.random.default_rng(7)
    both = np.column_stack([left, sound]) + random.normal(0, noise, (len(sound), 2))
    return np.clip(np.rint(both), -32_768, 32_767).astype(np.int16)


def bearings(stereo: NDArray[np.int16]) -> list[float]:
    finder = BearingFinder(DISTANCE)
    found = (finder.find(stereo[start : start + WINDOW]) for start in range(0, len(stereo) - WINDOW, WINDOW))
    return [each for each in found if each is not None]


@pytest.mark.parametrize("degrees", [-80, -45, -10, 0, 5, 30, 60, 85])
def test_a_voice_is_heard_from_where_it_is(degrees: int) -> None:
    found = bearings(heard_from(math.radians(degrees), stereo_48k(voice(1.0))[:, 0]))
    assert len(found) >= 8
    assert math.degrees(float(np.median(found))) == pytest.approx(degrees, abs=4 if abs(degrees) < 70 else 10)


def test_noise_is_heard_from_where_it_is() -> None:
    found = bearings(heard_from(0.5, stereo_48k(not_speech()["white noise"])[:, 0]))
    assert np.allclose(found, 0.5, atol=0.05)


def test_diffuse_sound_has_no_bearing() -> None:
    random = np.random.default_rng(2)
    assert bearings(random.normal(0, 3000, (48_000, 2)).astype(np.int16)) == []
    assert bearings(np.zeros((48_000, 2), np.int16)) == []


def test_a_delay_longer_than_the_distance_is_at_the_side() -> None:
    sound = stereo_48k(voice(1.0))[:, 0]
    finder = BearingFinder(0.02)
    assert finder.find(np.column_stack([np.roll(sound, 3), sound])[:WINDOW]) == pytest.approx(math.pi / 2)


def test_equal_channels_are_no_stereo() -> None:
    mono = stereo_48k(voice(0.2))
    assert not is_stereo(mono)
    assert not is_stereo(np.zeros_like(mono))
    assert is_stereo(heard_from(0.3, mono[:, 0]))
    assert is_stereo(heard_from(0.0, mono[:, 0]))
