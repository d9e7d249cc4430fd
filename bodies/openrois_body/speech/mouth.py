"""Mouth shapes from sound alone, for speech without phonemes. Pure.

A small network (`mouth_weights`) says of every 10 ms of sound which of the mouth shapes it goes with; `tools/mouth`
fits it to sentences of which the phonemes are known. How far the mouth opens is decided first, the shape within that
second: lips that close at the wrong moment are seen, `ih` in the place of `nn` is not.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import SAMPLE_RATE

from openrois_body.messages import VISEMES, Viseme
from openrois_body.speech.mouth_features import HOP_MS, LOOK_AHEAD_MS, SoundFeatures, as_float
from openrois_body.speech.mouth_weights import HIDDEN, SHAPES
from openrois_body.speech.visemes import CLOSED, Shape

__all__ = ["LABELS", "MouthReader", "Opening", "Shapes", "SoundMouth", "opening"]


class Opening(IntEnum):
    """How far a mouth is open: lips that touch each other or the teeth, a gap, or clearly open."""

    CLOSED = 0
    HALF = 1
    OPEN = 2


_LIPS_TOUCH: Final = frozenset((CLOSED, "PP", "FF"))
_WIDE: Final = frozenset(("aa", "E", "oh"))
_WEAK: Final = 0.5
"""Weight below which an open shape is half open: a vowel that is hardly said."""


def opening(shape: str, weight: float) -> Opening:
    """Return how far the mouth is open with a shape of this weight."""
    if shape in _LIPS_TOUCH:
        return Opening.CLOSED
    return Opening.OPEN if shape in _WIDE and weight >= _WEAK else Opening.HALF


LABELS: Final = (*(Shape(shape, 0.9 if shape in _WIDE else 1.0) for shape in VISEMES), Shape("E", 0.48))
"""The shapes that are told apart; the last one is the vowel of an unstressed syllable."""

_OPENING_OF: Final = np.array([opening(*label) for label in LABELS])
_SILENT: Final = VISEMES.index(CLOSED)
_NEW: Final = np.float32(0.7)
"""The share of each new moment in what is likely: a single odd one moves nothing."""
_SEEN: Final = np.array([1.3, 1.0, 1.3])
"""How much each opening counts: lips that do not close, and a mouth that does not open, are missed by viewers."""
_CLEARLY: Final = 3.0
"""How much likelier another shape of the same opening has to be."""
_ENOUGH_MS: Final = LOOK_AHEAD_MS + HOP_MS
"""Of silence behind the end, so that all moments before it are known."""


class Shapes(NamedTuple):
    """Mouth shapes in order of time, offsets from the beginning of the speech, and until when they hold, in ms."""

    visemes: Sequence[Viseme]
    until_ms: float


class MouthReader(Protocol):
    """Reads mouth shapes from one speech, in the order of its sound."""

    def push(self, samples: NDArray[np.int16]) -> Shapes:
        """Read on (mono, 48 kHz); returns the shapes that are known by now and were not returned before.

        The first of them is the shape at the end of those before. It may stay behind the sound by what it looks ahead.
        """
        ...

    def finish(self) -> Shapes:
        """Return the shapes up to the end of the sound; what is pushed after that is other sound, behind it."""
        ...


class SoundMouth:
    """Reads mouth shapes from the spectrum of speech; a `MouthReader`.

    A shape is known when `LOOK_AHEAD_MS` of sound behind its beginning have come. The mouth is closed in pauses, in
    noise that goes on, and at the end.

    Args:
        rate: samples a second, 16,000 to 48,000.
    """

    def __init__(self, rate: int = SAMPLE_RATE) -> None:
        self._rate = rate
        self._features = SoundFeatures(rate)
        self._begin_ms = 0.0
        """Where the sound begins whose moments are counted: behind what was finished."""
        self._samples = 0
        self._moments = 0
        self._shown = _SILENT
        self._likely = np.zeros(len(LABELS), np.float32)
        """How likely each label was lately."""

    def push(self, samples: NDArray[np.int16] | NDArray[np.float32]) -> Shapes:
        """Read on; mono, int16 or floats between -1 and 1.

        Raises:
            ValueError: the samples are not mono, or neither int16 nor float.
        """
        sound = as_float(samples)
        self._samples += len(sound)
        return self._read(sound)

    def finish(self) -> Shapes:
        """Return the shapes up to the end of the sound, where the mouth closes; then another sound may follow."""
        end = self._begin_ms + self._samples * 1000 / self._rate
        rest = self._read(np.zeros(round(self._rate * _ENOUGH_MS / 1000), np.float32))
        visemes = [viseme for viseme in rest.visemes if viseme.offset_ms < end]
        if not visemes or visemes[-1].shape != CLOSED:
            visemes.append(Viseme(round(end, 1), CLOSED, 1.0))
        self._features, self._begin_ms = SoundFeatures(self._rate), end
        self._samples = self._moments = 0
        self._shown = _SILENT
        self._likely[:] = 0
        return Shapes(visemes, end)

    @property
    def _now_ms(self) -> float:
        return self._begin_ms + self._moments * HOP_MS

    def _read(self, sound: NDArray[np.float32]) -> Shapes:
        found = [self._shape()]
        for moment in self._features.add(sound):
            shown = _SILENT if moment.is_pause else self._decide(moment.features)
            if shown != self._shown:
                self._shown = shown
                found = [*(each for each in found if each.offset_ms < self._now_ms), self._shape()]
            self._moments += 1
        return Shapes(found, self._now_ms)

    def _decide(self, features: NDArray[np.float32]) -> int:
        """Return the likeliest label of the likeliest opening; of two that are nearly as likely, the shown one."""
        self._likely += _NEW * (_likelihoods(features) - self._likely)
        chosen = int((np.bincount(_OPENING_OF, self._likely) * _SEEN).argmax())
        among = np.where(np.equal(_OPENING_OF, chosen), self._likely, 0)
        best = int(among.argmax())
        return self._shown if among[self._shown] * _CLEARLY > among[best] else best

    def _shape(self) -> Viseme:
        shape, weight = LABELS[self._shown]
        return Viseme(self._now_ms, shape, weight)


def _likelihoods(features: NDArray[np.float32]) -> NDArray[np.float32]:
    hidden = np.tanh(HIDDEN[:, :-1] @ features + HIDDEN[:, -1])
    scores = SHAPES[:, :-1] @ hidden + SHAPES[:, -1]
    likely = np.exp(scores - scores.max())
    return np.asarray(likely / likely.sum(), np.float32)
