"""When the mouth of sound that waits to be played is read."""

import numpy as np
from openrois_body.messages import Viseme
from openrois_body.speech.lips import Lips
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
    lips = Lips(mouth)
    for _ in range(4):
        lips.push(sound(0.2))
    assert len(list(lips.read(0.8, is_whole=False))) == 1
    assert list(lips.read(0.8, is_whole=False)) == []
    assert len(list(lips.read(0.7, is_whole=False))) == 1
    assert mouth.pieces == [24_000, 4_800]
    assert lips.read_samples == 28_800
    assert [each.visemes[0].shape for each in lips.read(0.4, is_whole=True)] == ["aa", "sil"]
    assert list(lips.read(0.1, is_whole=True)) == []
    assert lips.read_samples == 38_400


def test_after_a_pause_it_is_another_sound() -> None:
    mouth = Counting()
    lips = Lips(mouth)
    lips.push(sound(2))
    assert len(list(lips.read(2, is_whole=False))) == 1
    lips.restart()
    assert mouth.finished == 1
    lips.push(sound(0.1))
    assert [each.visemes[0].shape for each in lips.read(0.1, is_whole=True)] == ["aa", "sil"]
    assert mouth.finished == 2
    lips.restart()
    assert mouth.finished == 2
