from dataclasses import astuple
from itertools import combinations, pairwise

import pytest
from openrois_avatar.engines.animation.pose import Mouth
from openrois_avatar.engines.animation.visemes import CUT, SHAPES, Track, blended
from openrois_avatar.link.messages import VISEMES

LONG = 1.0


def mouth(track: Track, time: float) -> Mouth:
    return blended([track.share(time)])


def distance(first: Mouth, second: Mouth) -> float:
    return max(abs(float(a) - float(b)) for a, b in zip(astuple(first), astuple(second), strict=True))


def test_there_is_a_shape_for_every_viseme_of_the_link() -> None:
    assert tuple(SHAPES) == VISEMES
    assert SHAPES["sil"] == Mouth()


@pytest.mark.parametrize(("first", "second"), list(combinations(VISEMES, 2)))
def test_every_viseme_gives_a_mouth_of_its_own(first: str, second: str) -> None:
    assert distance(SHAPES[first], SHAPES[second]) >= 0.1


@pytest.mark.parametrize("name", VISEMES)
def test_a_viseme_held_long_enough_is_reached_fully(name: str) -> None:
    assert distance(mouth(Track(5.0, [(0.0, name, 1.0)], LONG), 5.5), SHAPES[name]) < 1e-9


def test_a_weight_scales_the_shape() -> None:
    half = mouth(Track(0.0, [(0.0, "aa", 0.5)], LONG), 0.5)
    assert half.jaw == pytest.approx(SHAPES["aa"].jaw / 2)


def test_lips_move_before_the_sound_and_rest_after_it() -> None:
    track = Track(5.0, [(0.0, "aa", 1.0)], LONG)
    assert mouth(track, 4.9) == Mouth()
    assert 0.0 < mouth(track, 4.97).jaw < mouth(track, 5.0).jaw < mouth(track, 5.03).jaw
    assert mouth(track, 6.1) == Mouth()
    assert not track.over(6.1)
    assert track.over(7.0)


def test_closed_lips_close_even_when_they_are_short() -> None:
    track = Track(0.0, [(0.0, "aa", 1.0), (0.30, "PP", 1.0), (0.37, "aa", 1.0)], LONG)
    closed = mouth(track, 0.335)
    assert closed.press > 0.75
    assert closed.jaw < 0.3


def test_lips_are_open_when_a_plosive_is_heard_to_burst() -> None:
    track = Track(5.0, [(0.0, "sil", 1.0), (0.2, "PP", 1.0), (0.233, "aa", 1.0), (0.425, "sil", 1.0)], LONG)
    assert mouth(track, 5.2).press > 0.5
    opened = next(ms for ms in range(200, 425) if mouth(track, 5.0 + ms / 1000).jaw > 0.4)
    assert abs(opened - 233) <= 10


def test_a_mouth_between_two_shapes_flows() -> None:
    track = Track(0.0, [(0.06 * n, VISEMES[n * 7 % 15], 1.0) for n in range(40)], 2.4)
    shapes = [mouth(track, n / 60) for n in range(160)]
    assert max(distance(a, b) for a, b in pairwise(shapes)) < 0.4


def test_a_cut_closes_the_mouth_at_once_but_not_in_a_jump() -> None:
    track = Track(0.0, [(0.0, "aa", 1.0)], LONG)
    track.cut(0.5)
    track.cut(0.7)
    assert mouth(track, 0.5).jaw == SHAPES["aa"].jaw
    assert 0.0 < mouth(track, 0.5 + CUT / 2).jaw < SHAPES["aa"].jaw
    assert mouth(track, 0.5 + CUT).jaw == 0.0
    assert track.over(0.8)


def test_a_cut_after_the_end_changes_nothing() -> None:
    track = Track(0.0, [(0.0, "aa", 1.0)], LONG)
    track.cut(LONG)
    assert mouth(track, 0.9).jaw > 0.5


def test_visemes_after_the_duration_are_not_played() -> None:
    track = Track(0.0, [(0.0, "aa", 1.0), (2.0, "ou", 1.0)], LONG)
    assert mouth(track, 2.1) == Mouth()


def test_a_track_of_nothing_rests() -> None:
    track = Track(0.0, [], LONG)
    assert mouth(track, 0.5) == Mouth()
    assert track.accent(0.5) == 0.0


def test_two_tracks_meet_without_a_jump() -> None:
    first, second = Track(0.0, [(0.0, "aa", 1.0)], LONG), Track(LONG, [(0.0, "ou", 1.0)], LONG)
    shapes = [blended([first.share(n / 60), second.share(n / 60)]) for n in range(120)]
    assert max(distance(a, b) for a, b in pairwise(shapes)) < 0.35
    assert shapes[90].round == pytest.approx(1.0)


def test_clear_vowels_are_stressed_but_not_too_often() -> None:
    track = Track(0.0, [(0.1 * n, "aa", 1.0) for n in range(20)], 2.0)
    levels = [track.accent(n / 60) for n in range(150)]
    peaks = [n for n in range(1, 149) if levels[n - 1] < levels[n] >= levels[n + 1] and levels[n] > 0.9]
    assert len(peaks) == 4
    assert max(abs(a - b) for a, b in pairwise(levels)) < 0.2


def test_consonants_are_not_stressed() -> None:
    track = Track(0.0, [(0.2 * n, "SS", 1.0) for n in range(10)], 2.0)
    assert not any(track.accent(n / 30) for n in range(60))
