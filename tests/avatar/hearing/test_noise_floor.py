from collections.abc import Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st
from openrois_avatar.hearing.noise_floor import HIGHEST, LOWEST, MEMORY, Loudness, NoiseFloor

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
def test_what_goes_on_unchanged_becomes_background_unless_it_is_really_loud(
    level: float, becomes_background: bool
) -> None:
    told = louds([-70.0, *[level] * 200])
    assert told[1]
    assert told[-1] is not becomes_background


def test_a_moment_above_the_floor_is_told_apart_from_the_time_that_it_holds() -> None:
    loudness = Loudness(INTERVAL, on=10, off=6, hold=0.3)
    assert [loudness.add(level) for level in (-60.0, -52.0, -40.0, -52.0, -55.0)] == [False, False, True, True, False]
    assert loudness.loud
