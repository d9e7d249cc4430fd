from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openrois_avatar.engines.animation.animator import Animator
from openrois_avatar.engines.animation.visemes import Track
from openrois_avatar.engines.animation.voice_mouth import HOLD, VoiceMouth

from tests.support.hearing import RATE, stereo_48k, voice

VOICE = stereo_48k(np.concatenate((np.zeros(RATE // 2, np.int16), voice(1.0), np.zeros(RATE // 2, np.int16))))[:, :1]
BLOCKS = list(VOICE.reshape(-1, 480, 1))
"""A voice from 0.5 s to 1.5 s, in 10 ms each."""


def test_the_mouth_moves_with_the_voice_and_closes_with_silence() -> None:
    mouth, jaws = VoiceMouth(), []
    for number, block in enumerate(BLOCKS):
        mouth.hear(number / 100, [block])
        jaws.append(mouth.shape(number / 100).jaw)
    assert max(jaws[:48]) == 0.0
    assert max(jaws[55:150]) > 0.25
    assert max(jaws[180:]) < 0.02


def test_the_mouth_closes_when_nothing_more_is_heard() -> None:
    mouth = VoiceMouth()
    mouth.hear(0.0, BLOCKS[:100])
    assert mouth.shape(HOLD).jaw > 0.1
    assert mouth.shape(HOLD + 0.3).jaw < 0.001


@given(st.lists(st.tuples(st.floats(0, 0.5), st.integers(0, 190), st.integers(1, 10)), max_size=20))
@settings(deadline=None, max_examples=30)
def test_mouth_never_jumps_and_never_opens_too_far(heard: list[tuple[float, int, int]]) -> None:
    mouth, time = VoiceMouth(), 0.0
    for pause, first, count in heard:
        jaws = [mouth.shape(time + pause * step / 200).jaw for step in range(201)]
        assert all(0.0 <= jaw <= 1.0 for jaw in jaws)
        assert all(abs(after - before) < 0.09 for before, after in pairwise(jaws))
        time += pause
        before = mouth.shape(time).jaw
        mouth.hear(time, BLOCKS[first : first + count])
        assert mouth.shape(time).jaw == pytest.approx(before)


def test_the_avatar_s_own_speech_comes_first() -> None:
    animator = Animator()
    animator.speak(0.0, Track(0.0, [(0.0, "PP", 1.0)], 2.0))
    animator.follow_voice(0.9, BLOCKS[:80])
    assert animator.pose(1.0).mouth.jaw < 0.1
    silent = Animator()
    silent.follow_voice(0.9, BLOCKS[:80])
    assert silent.pose(1.0).mouth.jaw > 0.2
