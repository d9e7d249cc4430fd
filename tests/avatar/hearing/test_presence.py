import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_avatar.hearing.presence import Presence

from tests.support.hearing import not_speech, stereo_48k, voice

SILENCE = np.zeros((24_000, 2), np.int16)


def changes(sound: NDArray[np.int16], block: int = 480) -> list[tuple[int, float]]:
    """The numbers that are another one than before, and the seconds at which they came."""
    presence, told = Presence(), [(0, 0.0)]
    for start in range(0, len(sound), block):
        number = presence.add(sound[start : start + block])
        if number != told[-1][0]:
            told.append((number, start / 48_000))
    return told[1:]


def test_a_sound_is_one_source_from_its_beginning_to_its_end() -> None:
    (begin, began), (end, ended) = changes(np.concatenate([SILENCE, stereo_48k(voice(1.0)), SILENCE]))
    assert (begin, end) == (1, 0)
    assert 0.5 <= began < 0.6
    assert 1.5 < ended < 2.0


def test_whatever_makes_a_sound_is_one() -> None:
    for name, sound in not_speech().items():
        told = changes(np.concatenate([SILENCE, stereo_48k(sound), SILENCE]))
        assert [number for number, _ in told][:1] == ([] if name == "silence" else [1]), name
        assert [number for number, _ in told][-1:] == ([] if name == "silence" else [0]), name


def test_noise_in_which_nothing_happens_is_none() -> None:
    noise = np.random.default_rng(5).normal(0, 60, (96_000, 2)).astype(np.int16)
    assert changes(noise) == []


@pytest.mark.parametrize("block", [7, 441, 960, 2000, 100_000])
def test_blocks_make_no_difference(block: int) -> None:
    sound = np.concatenate([SILENCE, stereo_48k(voice(0.2)), SILENCE])
    told = changes(sound, block)
    assert [number for number, _ in told] == ([1, 0] if block < len(sound) else [])
