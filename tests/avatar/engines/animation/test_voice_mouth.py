from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_avatar.engines.animation.animator import Animator
from openrois_avatar.engines.animation.visemes import Track
from openrois_avatar.engines.animation.voice_mouth import HOLD, VoiceMouth, loudness


def test_loudness_is_between_quiet_and_loud() -> None:
    assert loudness([]) == loudness([np.zeros((0, 1), np.int16)]) == loudness([np.zeros((9, 1), np.int16)]) == 0.0
    assert loudness([np.full((9, 1), 100, np.int16)]) == 0.0
    assert loudness([np.full((9, 2), 1000, np.int16)]) == pytest.approx(0.49, abs=0.01)
    assert loudness([np.full((9, 1), 30_000, np.int16), np.full((9, 1), -30_000, np.int16)]) == 1.0


def test_the_mouth_opens_fast_and_closes_when_nothing_more_is_heard() -> None:
    voice = VoiceMouth()
    assert voice.opening(5.0) == 0.0
    voice.set_loudness(5.0, 0.8)
    assert voice.opening(5.0) == 0.0
    assert voice.opening(5.0 + HOLD) > 0.75
    assert voice.opening(5.0 + HOLD + 1.0) < 0.001
    voice.set_loudness(7.0, 1.0)
    voice.set_loudness(7.1, 0.0)
    assert 0.2 < voice.opening(7.2) < 0.5


@given(st.lists(st.tuples(st.floats(0, 0.5), st.floats(0, 1)), max_size=20))
def test_mouth_never_jumps_and_never_opens_too_far(heard: list[tuple[float, float]]) -> None:
    voice, time = VoiceMouth(), 0.0
    for pause, level in heard:
        openings = [voice.opening(time + pause * step / 200) for step in range(201)]
        assert all(0.0 <= opening <= 1.0 for opening in openings)
        assert all(abs(after - before) < 0.09 for before, after in pairwise(openings))
        time += pause
        before = voice.opening(time)
        voice.set_loudness(time, level)
        assert voice.opening(time) == pytest.approx(before)


def test_the_avatar_s_own_speech_comes_first() -> None:
    animator = Animator()
    animator.speak(0.0, Track(0.0, [(0.0, "PP", 1.0)], 2.0))
    animator.follow_voice(0.9, 1.0)
    assert animator.pose(1.0).mouth.jaw < 0.1
    silent = Animator()
    silent.follow_voice(0.9, 1.0)
    assert silent.pose(1.0).mouth.jaw > 0.5
