"""The microphone of a visitor in a quiet room, who says what a test asks for."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import RawAudio

from tests.support.hearing import stereo_48k
from tests.support.sounds import paced

__all__ = ["Microphone"]

_BLOCK = 960


class Microphone:
    """Is recorded at the speed of sound, as a real one."""

    def __init__(self) -> None:
        self._noise = np.random.default_rng(1).integers(-30, 30, (_BLOCK, 2), np.int16)
        self._blocks: list[np.ndarray[Any, np.dtype[np.int16]]] = []

    def say(self, speech: NDArray[np.int16]) -> None:
        """Let the visitor say something from now on, given as 16 kHz mono."""
        sound = stereo_48k(speech)
        padded = np.concatenate([sound, np.zeros((-len(sound) % _BLOCK, 2), np.int16)])
        self._blocks += [each + self._noise for each in padded.reshape(-1, _BLOCK, 2)]

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[RawAudio]]:
        """Record while the block runs."""
        yield paced(lambda _number: self._blocks.pop(0) if self._blocks else self._noise)
