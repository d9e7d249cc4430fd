"""Mouth shapes read from sound: closed in silence, the same whatever the pieces, and never unknown ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from openrois_body.messages import VISEMES, Viseme
from openrois_body.speech.mouth import LABELS, Opening, SoundMouth, opening
from openrois_body.speech.mouth_features import LOOK_AHEAD_MS
from openrois_body.speech.visemes import Shape

from tests.support.hearing import voice
from tests.support.mouth import openings, read_mouth

RATE = 16_000
SILENCE = np.zeros(RATE, np.int16)


def opening_at(shapes: list[Viseme], *seconds: float) -> list[Opening]:
    return [Opening(each) for each in openings(shapes, np.array(seconds) * 1000)]


def test_silence_closes_the_mouth() -> None:
    assert read_mouth(SILENCE, RATE) == [Viseme(0.0, "sil", 1.0)]
    shapes = read_mouth(np.concatenate((SILENCE, voice(1.0), SILENCE)), RATE)
    assert opening_at(shapes, 0.5, 0.9, 2.15, 2.5) == [Opening.CLOSED] * 4
    assert set(opening_at(shapes, *np.arange(1.1, 1.9, 0.01))) >= {Opening.OPEN}
    assert shapes[-1].shape == "sil"


def test_noise_that_goes_on_closes_the_mouth_and_speech_above_it_opens_it() -> None:
    noise = np.random.default_rng(3).normal(0, 60, 10 * RATE)
    noise[9 * RATE :] += voice(1.0)
    shapes = read_mouth(noise.astype(np.int16), RATE)
    assert set(opening_at(shapes, *np.arange(1.1, 8.9, 0.01))) == {Opening.CLOSED}
    assert set(opening_at(shapes, *np.arange(9.1, 9.9, 0.01))) >= {Opening.OPEN}


def test_noise_that_begins_later_closes_the_mouth_within_eight_seconds() -> None:
    noise = np.random.default_rng(3).normal(0, 500, 9 * RATE).astype(np.int16)
    shapes = read_mouth(np.concatenate((SILENCE, SILENCE, noise)), RATE)
    assert set(opening_at(shapes, *np.arange(2.1, 5.0, 0.01))) > {Opening.CLOSED}
    assert set(opening_at(shapes, *np.arange(10.1, 10.9, 0.01))) == {Opening.CLOSED}


def test_what_comes_after_the_end_is_another_sound_behind_it() -> None:
    mouth, sound = SoundMouth(RATE), voice(0.5)
    first = [*mouth.push(sound).visemes, *mouth.finish().visemes]
    pushed = mouth.push(sound)
    second = [*pushed.visemes, *mouth.finish().visemes]
    assert pushed.visemes[0].offset_ms == 500
    assert [Viseme(each.offset_ms - 500, each.shape, each.weight) for each in second] == first


@given(st.lists(st.integers(1, 4_000), min_size=1, max_size=20), st.sampled_from([16_000, 22_050, 24_000, 48_000]))
@settings(max_examples=20, deadline=None)
def test_how_the_sound_is_cut_up_changes_nothing(sizes: list[int], rate: int) -> None:
    sound = np.concatenate((voice(0.4), SILENCE[:2_000], voice(0.3, 210)))
    mouth, found, until, first = SoundMouth(rate), list[Viseme](), 0.0, 0
    while first < len(sound):
        size = sizes[first % len(sizes)]
        shapes = mouth.push(sound[first : first + size])
        first += size
        assert shapes.visemes[0].offset_ms == until <= shapes.until_ms
        assert shapes.until_ms > min(first, len(sound)) * 1000 / rate - LOOK_AHEAD_MS - 0.1
        found += shapes.visemes if shapes.until_ms > until else ()
        until = shapes.until_ms
    found += mouth.finish().visemes
    whole = read_mouth(sound, rate, len(sound))
    times = np.arange(0, len(sound) * 1000 / rate, 1.0)
    assert (openings(found, times) == openings(whole, times)).all()


def test_shapes_stay_less_than_40_ms_behind_the_sound() -> None:
    assert LOOK_AHEAD_MS < 40
    mouth, sound = SoundMouth(), np.repeat(voice(1.0), 3)
    for first in range(0, len(sound), 96):
        assert (first + 96) / 48 - mouth.push(sound[first : first + 96]).until_ms < LOOK_AHEAD_MS + 2


SAMPLES = st.one_of(
    st.lists(st.floats(width=32), max_size=1_500).map(lambda values: np.array(values, np.float32)),
    st.lists(st.integers(-32_768, 32_767), max_size=1_500).map(lambda values: np.array(values, np.int16)),
    st.builds(
        lambda value, count: np.full(count, value, np.int16), st.integers(-32_768, 32_767), st.integers(0, 9_000)
    ),
    st.builds(
        lambda seed, scale: np.random.default_rng(seed).normal(0, scale, 5_000).astype(np.float32),
        st.integers(0, 99),
        st.floats(0, 1e30),
    ),
)


@given(st.lists(SAMPLES, max_size=5))
@settings(max_examples=60, deadline=None)
def test_any_samples_are_read(pieces: list[NDArray[np.int16] | NDArray[np.float32]]) -> None:
    mouth, until = SoundMouth(RATE), 0.0
    for shapes in (*map(mouth.push, pieces), mouth.finish()):
        offsets = [each.offset_ms for each in shapes.visemes]
        assert offsets == sorted(offsets)
        assert until <= shapes.until_ms
        assert all(each.shape in VISEMES and 0 <= each.weight <= 1 for each in shapes.visemes)
        until = shapes.until_ms
    assert until == sum(map(len, pieces)) * 1000 / RATE
    assert shapes.visemes[-1].shape == "sil"


def test_what_cannot_be_read_is_refused_with_the_reason() -> None:
    with pytest.raises(ValueError, match="between 16000 and 48000 Hz"):
        SoundMouth(8_000)
    with pytest.raises(ValueError, match="mono"):
        SoundMouth().push(np.zeros((10, 2), np.int16))
    with pytest.raises(ValueError, match="int16 or float32"):
        SoundMouth().push(np.zeros(10, np.int64))  # type: ignore[arg-type]


def test_every_shape_has_an_opening_and_a_weak_one_is_less_open() -> None:
    assert {label.name for label in LABELS} == set(VISEMES)
    assert {opening(*label) for label in LABELS} == set(Opening)
    assert opening(*Shape("E", 0.48)) < opening(*Shape("E", 1.0))
    assert opening("PP", 1.0) == opening("FF", 1.0) == opening("sil", 1.0) == Opening.CLOSED
