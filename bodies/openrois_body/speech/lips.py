"""Mouth shapes of sound that waits to be played, read shortly before it is. Pure."""

from collections import deque
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import SAMPLE_RATE

from openrois_body.speech.mouth import MouthReader, Shapes

__all__ = ["Lips"]

_AHEAD: Final = 0.5
"""Seconds before sound is played in which its mouth shapes are read: an engine keeps few movements at a time."""


class Lips:
    """Gives the sound of a speech to the reader of its mouth, in order and in time.

    Args:
        mouth: reads mouth shapes from the sound.
    """

    def __init__(self, mouth: MouthReader) -> None:
        self._mouth = mouth
        self._unread: deque[NDArray[np.int16]] = deque()
        self._unread_samples = 0
        self._ended = False
        self.read_samples = 0
        """Samples that were read so far."""

    def push(self, samples: NDArray[np.int16]) -> None:
        """Append sound (mono, 48 kHz)."""
        self._unread.append(samples)
        self._unread_samples += len(samples)

    def read(self, ahead: float, *, is_whole: bool) -> Iterator[Shapes]:
        """Return the shapes of what is played soon; use all of them.

        Args:
            ahead: seconds from what is played now to the end of what was pushed.
            is_whole: whether no more sound comes.
        """
        wanted = round((_AHEAD - ahead) * SAMPLE_RATE) + self._unread_samples
        pieces: list[NDArray[np.int16]] = []
        while self._unread and wanted > 0:
            piece = self._unread.popleft()
            if len(piece) > wanted:
                self._unread.appendleft(piece[wanted:])
            pieces.append(piece[:wanted])
            wanted -= len(pieces[-1])
        if pieces:
            sound = np.concatenate(pieces)
            self._unread_samples -= len(sound)
            self.read_samples += len(sound)
            yield self._mouth.push(sound)
        if is_whole and not self._unread and not self._ended:
            self._ended = True
            yield self._mouth.finish()

    def restart(self) -> None:
        """Forget what was not read: what is pushed from now on is another sound."""
        self._unread.clear()
        self._unread_samples = 0
        if not self._ended:
            self._mouth.finish()
        self._ended = False
