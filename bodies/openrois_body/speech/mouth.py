"""Mouth shapes from sound alone, for speech without phonemes."""

from collections.abc import Sequence
from math import log10
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import SAMPLE_RATE

from openrois_body.messages import Viseme
from openrois_body.speech.visemes import CLOSED

__all__ = ["LoudnessMouth", "MouthReader", "Shapes"]

_FRAME: Final = SAMPLE_RATE // 50
_QUIET: Final = -45.0
_LOUD: Final = -18.0
"""Root mean squares in dBFS at which the mouth begins to open, and at which it is open."""
_STEPS: Final = 8
"""Openings that are told apart: of others the engine would be told for every 20 ms of sound."""


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
        """Return the shapes up to the end of the sound."""
        ...


class LoudnessMouth:
    """Opens the mouth with the loudness of each 20 ms; a `MouthReader`."""

    def __init__(self) -> None:
        self._rest = np.zeros(0, np.int16)
        self._frames = 0
        self._last = Viseme(0.0, CLOSED, 1.0)

    def push(self, samples: NDArray[np.int16]) -> Shapes:
        """Read on."""
        sound = np.concatenate((self._rest, samples))
        count = len(sound) // _FRAME
        self._rest = sound[count * _FRAME :]
        return self._read(sound[: count * _FRAME].reshape(count, _FRAME))

    def finish(self) -> Shapes:
        """Read what does not fill a frame."""
        rest, self._rest = self._rest, self._rest[:0]
        return self._read(np.pad(rest, (0, _FRAME - len(rest))).reshape(1, _FRAME) if len(rest) else rest.reshape(0, 1))

    def _read(self, frames: NDArray[np.int16]) -> Shapes:
        first = self._frames
        found = [Viseme(first * 20.0, self._last.shape, self._last.weight)]
        for power in np.mean(np.square(frames, dtype=np.float32), axis=1) if len(frames) else ():
            viseme = _opening(self._frames * 20.0, float(power))
            if (viseme.shape, viseme.weight) != (self._last.shape, self._last.weight):
                found.append(viseme)
                self._last = viseme
            self._frames += 1
        if len(found) > 1 and found[1].offset_ms == found[0].offset_ms:
            del found[0]
        return Shapes(found, self._frames * 20.0)


def _opening(offset_ms: float, power: float) -> Viseme:
    level = 10 * log10(max(power, 1e-3) / 32_768.0**2)
    opening = round(min(1.0, max(0.0, (level - _QUIET) / (_LOUD - _QUIET))) * _STEPS) / _STEPS
    return Viseme(offset_ms, "aa", opening) if opening else Viseme(offset_ms, CLOSED, 1.0)
