from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from openrois_body.hearing.noise_floor import HIGHEST, LOWEST, MEMORY, Loudness, NoiseFloor, Presence

from tests.support.hearing import not_speech, stereo_48k, voice

INTERVAL = 0.1


def louds(levels: Iterable[float], loudness: Loudness | None = None) -> list[bool]:
    loudness = loudness or Loudness(INTERVAL)
    told = []
    for level in levels:
        loudness.add(level)
        told.append(loudness.loud)
    return told


@given(st.lists(st.floats(-100, 0), min_size=1, max_size=300))
def test_the_floor_is_the_quietest_of_the_last_seconds(levels: list[float]) -> None:
    floor = NoiseFloor(INTERVAL)
    count = round(MEMORY / INTERVAL)
    for number, level in enumerate(levels):
        lowest = min(levels[max(0, number - count + 1) : number + 1])
        assert floor.add(level) == min(HIGHEST, max(LOWEST, lowest))


def test_something_begins_and_ends_once_whatever_it_does_between() -> None:
    quiet, sound = [-60.0] * 20, [-30.0, -52.0, -53.0, -30.0] * 5
    told = louds([*quiet, *sound, *quiet])
    assert told == [False] * 20 + [True] * (20 + 2) + [False] * 18


def test_rustling_in_a_silent_room_is_nothing() -> None:
    assert not any(louds([-100.0, -58.0] * 20))
    assert any(louds([-100.0, -54.0]))


@pytest.mark.parametrize(("level", "becomes_background"), [(-40.0, True), (-20.0, False)])
def test_constant_sound_becomes_background_unless_it_is_really_loud(level: float, becomes_background: bool) -> None:
    told = louds([-70.0, *[level] * 200])
    assert told[1]
    assert told[-1] is not becomes_background


def test_a_moment_above_the_floor_is_told_apart_from_the_time_that_it_holds() -> None:
    loudness = Loudness(INTERVAL, on=10, off=6, hold=0.3)
    assert [loudness.add(level) for level in (-60.0, -52.0, -40.0, -52.0, -55.0)] == [False, False, True, True, False]
    assert loudness.loud


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
