"""How much a sentence is like the sound: against sounds in any order, and with a voice outside of its words."""

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.hearing.likeness import UNLIKE, Likeness, Span, compare

_VOICE = np.tile(np.array([1000, -1000], np.int16), 80)
_NOISE = np.tile(np.array([10, -10], np.int16), 80)


def _sound(frames: str) -> NDArray[np.int16]:
    return np.concatenate([_VOICE if each == "v" else _NOISE for each in frames])


SOUND = _sound("." * 20 + "v" * 30 + "." * 20)
SILENCE = Span(0, 20, -20.0, is_said=False)


def test_a_sentence_is_measured_against_sounds_in_any_order() -> None:
    sounds = [Span(0, 20, -20.0), Span(20, 40, -2000.0), Span(40, 70, -3000.0)]
    words = [SILENCE, Span(20, 30, -2000.0), Span(30, 50, -5000.0), Span(50, 70, -20.0, is_said=False)]
    likeness = compare(words, sounds, SOUND)
    assert likeness.score == pytest.approx(-7000 / 30)
    assert likeness.worse == pytest.approx((7000 / 30 - 100) / 100)
    assert likeness.outside == 0


def test_a_voice_outside_of_the_words_is_counted_and_noise_is_not() -> None:
    rest = Span(42, 70, -100.0, is_said=False)
    assert compare([SILENCE, Span(20, 42, -100.0), rest], [], SOUND).outside == 8
    noisy = SOUND + np.tile(np.array([300, -300], np.int16), len(SOUND) // 2)
    assert compare([SILENCE, Span(20, 42, -100.0), rest], [], noisy).outside == 8


@pytest.mark.parametrize("found", [[], [SILENCE], [Span(500, 600, -1.0)]])
def test_no_words_are_like_nothing(found: list[Span]) -> None:
    assert compare(found, [], SOUND) == UNLIKE == Likeness(0.0, 0.0, 0)


def test_a_sound_of_less_than_a_frame_has_no_likeness() -> None:
    assert compare([Span(0, 1, -1.0)], [], SOUND[:50]) == UNLIKE
