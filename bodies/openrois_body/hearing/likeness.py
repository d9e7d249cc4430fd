"""How much a sentence that a recogniser found is like the sound: whether it was said, or the best of what fits badly.

Pure. A grammar finds its likeliest sentence in any sound. What tells whether that was said is how much better the same
sound is explained by sounds of speech in any order, and how much of the voice lies outside of the sentence's words.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["UNLIKE", "Likeness", "Span", "compare"]

_FRAME: Final = 160
"""Samples of a frame of 10 ms, at 16 kHz."""
_LOUD: Final = 0.1
"""As a part of the loudness that a fifth of the words' frames exceeds: from there on, other sound is a voice."""
_OVER_FLOOR: Final = 2.5
"""How many times as loud as the noise between the words a voice is at least."""


@dataclass(frozen=True, slots=True)
class Span:
    """A part of the sound: a word, or a sound of speech.

    Attributes:
        begin: its first frame.
        end: the frame behind its last.
        score: acoustic, of all its frames; the logarithm of a likelihood, so that more is likelier.
        is_said: whether it is a word, and no silence or noise.
    """

    begin: int
    end: int
    score: float
    is_said: bool = True


@dataclass(frozen=True, slots=True)
class Likeness:
    """How like a sentence is to the sound.

    Attributes:
        score: acoustic, of the words, per frame.
        worse: how much worse it is than that of sounds of speech in any order, as a part of the latter.
        outside: frames of a voice outside of the words.
    """

    score: float
    worse: float
    outside: int


UNLIKE: Final = Likeness(0.0, 0.0, 0)
"""The likeness of no words."""


def compare(found: Iterable[Span], sounds: Iterable[Span], samples: NDArray[np.int16]) -> Likeness:
    """Return how like the words of `found` are to the sound.

    Args:
        found: words, and silence and noises between them.
        sounds: the likeliest sounds of speech in the same sound.
        samples: the sound, at 16 kHz.
    """
    whole = samples[: len(samples) // _FRAME * _FRAME].astype(np.float64).reshape(-1, _FRAME)
    loudness = np.sqrt((whole**2).mean(axis=1))
    is_said = np.zeros(len(loudness), bool)
    ours, free = np.zeros(len(loudness)), np.zeros(len(loudness))
    for each in found:
        ours[each.begin : each.end] = each.score / (each.end - each.begin)
        is_said[each.begin : each.end] = each.is_said
    for each in sounds:
        free[each.begin : each.end] = each.score / (each.end - each.begin)
    if not is_said.any():
        return UNLIKE
    score, best = float(ours[is_said].mean()), float(free[is_said].mean())
    loud = max(_LOUD * np.percentile(loudness[is_said], 80), _OVER_FLOOR * np.percentile(loudness, 10))
    return Likeness(score, (best - score) / max(1.0, -best), int((~is_said & (loudness > loud)).sum()))
