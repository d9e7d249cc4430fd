"""When the mouth of sound that waits to be played is read."""

import numpy as np
from openrois_body.messages import Viseme
from openrois_body.speech.lips import SoundLips, ToldLips
from openrois_body.speech.mouth import Shapes


class Counting:
    """A reader that takes each piece for one shape, and remembers how many samples it had."""

    def __init__(self) -> None:
        self.pieces: list[int] = []
        self.finished = 0

    def push(self, samples: np.ndarray[tuple[int], np.dtype[np.int16]]) -> Shapes:
        self.pieces.append(len(samples))
        return Shapes([Viseme(0.0, "aa", 1.0)], 1.0)

    def finish(self) -> Shapes:
        self.finished += 1
        return Shapes([Viseme(1.0, "sil", 1.0)], 1.0)


def sound(seconds: float) -> np.ndarray[tuple[int], np.dtype[np.int16]]:
    return np.zeros(round(seconds * 48_000), np.int16)


def test_no_more_is_read_than_half_a_second_before_it_is_played() -> None:
    mouth = Counting()
    lips = SoundLips(mouth)
    for _ in range(4):
        lips.push(sound(0.2))
    assert len(list(lips.read_shapes(0.8, is_whole=False))) == 1
    assert list(lips.read_shapes(0.8, is_whole=False)) == []
    assert len(list(lips.read_shapes(0.7, is_whole=False))) == 1
    assert mouth.pieces == [24_000, 4_800]
    assert [each.visemes[0].shape for each in lips.read_shapes(0.4, is_whole=True)] == ["aa", "sil"]
    assert list(lips.read_shapes(0.1, is_whole=True)) == []
    assert mouth.pieces == [24_000, 4_800, 9_600]


def test_after_a_pause_it_is_another_sound() -> None:
    mouth = Counting()
    lips = SoundLips(mouth)
    lips.push(sound(2))
    assert len(list(lips.read_shapes(2, is_whole=False))) == 1
    lips.restart(0)
    assert mouth.finished == 1
    lips.push(sound(0.1))
    assert [each.visemes[0].shape for each in lips.read_shapes(0.1, is_whole=True)] == ["aa", "sil"]
    assert mouth.finished == 2
    lips.restart(0)
    assert mouth.finished == 2


def test_told_shapes_are_given_as_far_as_sound_has_come_when_the_last_ones_soon_end() -> None:
    lips = ToldLips()
    lips.add([Viseme(0.0, "aa", 1.0), Viseme(400.0, "PP", 0.5), Viseme(1900.0, "sil", 1.0)])
    lips.push(sound(0.3))
    assert list(lips.read_shapes(0.3, is_whole=False)) == [Shapes([Viseme(0.0, "aa", 1.0)], 300.0)]
    assert list(lips.read_shapes(0.3, is_whole=False)) == []
    lips.push(sound(0.7))
    assert list(lips.read_shapes(1.0, is_whole=False)) == [
        Shapes([Viseme(300.0, "aa", 1.0), Viseme(400.0, "PP", 0.5)], 1000.0)
    ]
    lips.push(sound(0.9))
    assert list(lips.read_shapes(1.6, is_whole=True)) == []
    assert list(lips.read_shapes(1.3, is_whole=True)) == [Shapes([Viseme(1000.0, "PP", 0.5)], 1900.0)]


def test_without_told_shapes_none_are_given() -> None:
    lips = ToldLips()
    lips.push(sound(0.3))
    assert list(lips.read_shapes(0.3, is_whole=True)) == []
    lips.add([Viseme(350.0, "aa", 1.0)])
    lips.push(sound(0.1))
    assert list(lips.read_shapes(0.4, is_whole=True)) == [Shapes([Viseme(350.0, "aa", 1.0)], 400.0)]


def test_after_a_pause_told_shapes_are_given_again_from_there_on() -> None:
    lips = ToldLips()
    lips.add([Viseme(0.0, "aa", 1.0), Viseme(500.0, "PP", 1.0), Viseme(800.0, "E", 1.0)])
    lips.push(sound(1.0))
    assert len(list(lips.read_shapes(1.0, is_whole=True))) == 1
    lips.restart(28_800)
    lips.push(sound(0.4))
    assert list(lips.read_shapes(0.4, is_whole=True)) == [
        Shapes([Viseme(0.0, "PP", 1.0), Viseme(200.0, "E", 1.0)], 400.0)
    ]
