"""A mouth that follows the operator's voice: its shapes are read from the sound as it arrives."""

from collections.abc import Sequence
from math import exp
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_body.speech.mouth import SoundMouth

from openrois_avatar.engines.animation.pose import Mouth
from openrois_avatar.engines.animation.visemes import PARTS, SHAPES

_FOLLOWING: Final = 0.035
"""Time constant in seconds with which the mouth takes a shape."""
HOLD: Final = 0.12
"""Seconds without sound after which the mouth closes."""
_REST: Final = (0.0,) * len(PARTS)


class VoiceMouth:
    """The shape of the mouth. Times are seconds on one clock and never go back."""

    def __init__(self) -> None:
        self._reader = SoundMouth()
        self._time = 0.0
        self._from = self._goal = _REST

    def hear(self, time: float, blocks: Sequence[NDArray[np.int16]]) -> None:
        """Follow sound that has arrived by now: blocks of shape (n, 1) at 48 kHz, in order."""
        shown = self._reader.push(np.concatenate([block[:, 0] for block in blocks])).visemes[-1]
        self._from = self._parts(time)
        self._time = time
        self._goal = tuple(shown.weight * getattr(SHAPES[shown.shape], part) for part in PARTS)

    def shape(self, time: float) -> Mouth:
        """Return the shape of the mouth at a time."""
        return Mouth(*self._parts(time))

    def _parts(self, time: float) -> tuple[float, ...]:
        since = time - self._time
        reached = _towards(self._from, self._goal, min(since, HOLD))
        return reached if since <= HOLD else _towards(reached, _REST, since - HOLD)


def _towards(parts: tuple[float, ...], goal: tuple[float, ...], seconds: float) -> tuple[float, ...]:
    left = exp(-seconds / _FOLLOWING)
    return tuple(end + (part - end) * left for part, end in zip(parts, goal, strict=True))
