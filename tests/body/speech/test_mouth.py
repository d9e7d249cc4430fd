"""Mouth shapes by the loudness of sound."""

import numpy as np
import pytest
from numpy.typing import NDArray
from openrois_body.messages import Viseme
from openrois_body.speech.mouth import LoudnessMouth


def tone(amplitude: float, samples: int) -> NDArray[np.int16]:
    return (np.sin(np.arange(samples) / 10) * amplitude * 32_767).astype(np.int16)


def test_it_opens_with_the_sound_and_closes_with_silence() -> None:
    shapes = LoudnessMouth().push(np.concatenate((tone(0.5, 4_800), np.zeros(4_800, np.int16), tone(0.03, 4_800))))
    assert shapes.until_ms == 300
    assert [(each.offset_ms, each.shape) for each in shapes.visemes[:2]] == [(0, "aa"), (100, "sil")]
    assert shapes.visemes[0].weight == 1
    assert 0 < shapes.visemes[2].weight < 0.7


def changes(shapes: list[Viseme]) -> list[Viseme]:
    """The shapes without those that are as the one before."""
    found: list[Viseme] = []
    for each in shapes:
        if not found or (found[-1].shape, found[-1].weight) != (each.shape, each.weight):
            found.append(each)
    return found


@pytest.mark.parametrize("size", [1, 100, 959, 960, 961, 5_000])
def test_how_the_sound_is_cut_up_changes_nothing(size: int) -> None:
    sound = np.concatenate([tone(loud, 3_000) for loud in (0.5, 0.0, 0.1, 0.02, 0.9)])
    whole = LoudnessMouth()
    expected = changes([*whole.push(sound).visemes, *whole.finish().visemes])
    mouth, found, until = LoudnessMouth(), list[Viseme](), 0.0
    for shapes in (*(mouth.push(sound[first : first + size]) for first in range(0, len(sound), size)), mouth.finish()):
        assert shapes.visemes[0].offset_ms == until <= shapes.until_ms
        if shapes.until_ms > until:
            found += shapes.visemes
        until = shapes.until_ms
    assert until == 20 * -(-len(sound) // 960)
    assert changes(found) == expected


def test_without_sound_nothing_moves() -> None:
    shapes = LoudnessMouth().finish()
    assert (shapes.until_ms, len(shapes.visemes)) == (0, 1)
