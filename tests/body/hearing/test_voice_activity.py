import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.hearing.voice_activity import END_SILENCE, LONGEST, VoiceActivity

from tests.support.hearing import RATE, not_speech, voice

pytestmark = pytest.mark.extra(name="body")

SILENCE = np.zeros(RATE, np.int16)


def turns(*sounds: NDArray[np.int16], block: int = 160, noise: float = 0.0) -> list[tuple[bool, float, float]]:
    """What began and ended: at which second, and at which it was noticed."""
    activity, told = VoiceActivity(), []
    sound = np.concatenate(sounds)
    if noise:
        sound = (sound + np.random.default_rng(4).normal(0, noise, len(sound))).astype(np.int16)
    for start in range(0, len(sound), block):
        told += [(speaking, at / RATE, start / RATE) for speaking, at in activity.add(sound[start : start + block])]
    return told


@pytest.mark.parametrize("pitch", [90.0, 140.0, 220.0, 300.0])
@pytest.mark.parametrize("noise", [0.0, 30.0])
def test_a_voice_begins_and_ends(pitch: float, noise: float) -> None:
    (begins, began, noticed), (goes_on, ended, seen) = turns(SILENCE, voice(1.2, pitch), SILENCE, noise=noise)
    assert (begins, goes_on) == (True, False)
    assert 0.9 <= began <= 1.2
    assert noticed - began < 0.4
    assert ended == pytest.approx(2.2, abs=0.2)
    assert seen - ended == pytest.approx(END_SILENCE, abs=0.1)


@pytest.mark.parametrize("name", not_speech())
@pytest.mark.parametrize("noise", [0.0, 60.0])
def test_nothing_else_is_taken_for_one(name: str, noise: float) -> None:
    assert turns(SILENCE, not_speech()[name], SILENCE, noise=noise) == []


def test_two_voices_one_after_the_other_are_two_and_a_pause_between_words_is_none() -> None:
    apart = turns(SILENCE, voice(1.0), SILENCE, voice(1.0, 200), SILENCE)
    assert [speaking for speaking, *_ in apart] == [True, False, True, False]
    close = turns(SILENCE, voice(1.0), SILENCE[: RATE // 3], voice(1.0), SILENCE)
    assert [speaking for speaking, *_ in close] == [True, False]


def test_noise_that_begins_during_speech_does_not_prolong_it() -> None:
    tone = not_speech()["a tone of 440 Hz"]
    (_, _, _), (_, ended, _) = turns(SILENCE, voice(1.0), tone, SILENCE)
    assert ended < 2.5


def test_endless_speech_is_cut_into_pieces() -> None:
    told = turns(SILENCE, voice(LONGEST + 2), SILENCE)
    assert [speaking for speaking, *_ in told] == [True, False, True, False]
    assert told[1][1] - told[0][1] == pytest.approx(LONGEST, abs=0.4)


@pytest.mark.parametrize("block", [1, 37, 640, 4000, 100_000])
def test_blocks_make_no_difference(block: int) -> None:
    said = (SILENCE[:4000], voice(0.6), SILENCE)
    assert [turn[:2] for turn in turns(*said, block=block)] == [turn[:2] for turn in turns(*said)]
