"""Mouth shapes of a speech, given shortly before its sound is played: read from the sound, or told with it. Pure."""

from collections import deque
from collections.abc import Iterable, Iterator
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import SAMPLE_RATE

from openrois_body.messages import Viseme
from openrois_body.speech.mouth import MouthReader, Shapes

__all__ = ["Lips", "SoundLips", "ToldLips"]

_AHEAD: Final = 0.5
"""Seconds before sound is played in which its mouth shapes are given: an engine keeps few movements at a time."""


class Lips(Protocol):
    """The mouth shapes of one speech, in the order of its sound. Offsets count from where it was last restarted."""

    def push(self, samples: NDArray[np.int16]) -> None:
        """Append sound (mono, 48 kHz)."""
        ...

    def read_shapes(self, ahead: float, *, is_whole: bool) -> Iterator[Shapes]:
        """Return the shapes of what is played soon; use all of them.

        Args:
            ahead: seconds from what is played now to the end of what was pushed.
            is_whole: whether no more sound comes.
        """
        ...

    def restart(self, heard: int) -> None:
        """Forget what was pushed: what is pushed from now on begins at sample `heard` of the speech."""
        ...


class SoundLips:
    """Gives the sound of a speech to the reader of its mouth, in order and in time.

    Args:
        mouth: reads mouth shapes from the sound.
    """

    def __init__(self, mouth: MouthReader) -> None:
        self._mouth = mouth
        self._unread: deque[NDArray[np.int16]] = deque()
        self._unread_samples = 0
        self._ended = False
        self._read = 0
        """Samples that were read so far."""
        self._begin_ms = 0.0
        """What was read before the restart."""

    def push(self, samples: NDArray[np.int16]) -> None:
        """Append sound."""
        self._unread.append(samples)
        self._unread_samples += len(samples)

    def read_shapes(self, ahead: float, *, is_whole: bool) -> Iterator[Shapes]:
        """Return the shapes of what is played soon."""
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
            self._read += len(sound)
            yield _earlier(self._mouth.push(sound), self._begin_ms)
        if is_whole and not self._unread and not self._ended:
            self._ended = True
            yield _earlier(self._mouth.finish(), self._begin_ms)

    def restart(self, heard: int) -> None:
        """Take what is pushed from now on for another sound, wherever it begins."""
        self._unread.clear()
        self._unread_samples = 0
        if not self._ended:
            self._mouth.finish()
        self._ended = False
        self._begin_ms = _milliseconds(self._read)


class ToldLips:
    """Gives mouth shapes that come with the sound, or before it: all that are known, when the last ones soon end."""

    def __init__(self) -> None:
        self._visemes: deque[Viseme] = deque()
        """Those of sound that is not heard yet; the first one is shown now. Offsets count from the first sample."""
        self._begin = 0
        """The sample of the speech at which it was restarted."""
        self._pushed = 0
        self._given = 0
        """Samples whose shapes were given."""

    def add(self, visemes: Iterable[Viseme]) -> None:
        """Add the next shapes, in order of time, before the sound that they begin in."""
        self._visemes.extend(visemes)

    def push(self, samples: NDArray[np.int16]) -> None:
        """Append sound."""
        self._pushed += len(samples)

    def read_shapes(self, ahead: float, *, is_whole: bool) -> Iterator[Shapes]:
        """Return the shapes of all that was pushed, if those that were given last end within half a second."""
        played = self._pushed - round(ahead * SAMPLE_RATE)
        self._drop_before(_milliseconds(played))
        if self._given == self._pushed or self._given - played > _AHEAD * SAMPLE_RATE:
            return
        until = _milliseconds(self._pushed)
        visemes = list(self._between(_milliseconds(self._given), until))
        self._given = self._pushed
        if visemes:
            yield _earlier(Shapes(visemes, until), _milliseconds(self._begin))

    def restart(self, heard: int) -> None:
        """Give the shapes from sample `heard` on again."""
        self._begin = self._pushed = self._given = heard
        self._drop_before(_milliseconds(heard))

    def _between(self, begin_ms: float, end_ms: float) -> Iterator[Viseme]:
        """Return the shape that is shown at a moment, as if it began there, and those that begin behind it."""
        shown = None
        for viseme in self._visemes:
            if viseme.offset_ms <= begin_ms:
                shown = viseme
                continue
            if shown is not None:
                yield Viseme(begin_ms, shown.shape, shown.weight)
                shown = None
            if viseme.offset_ms >= end_ms:
                return
            yield viseme
        if shown is not None:
            yield Viseme(begin_ms, shown.shape, shown.weight)

    def _drop_before(self, moment_ms: float) -> None:
        while len(self._visemes) > 1 and self._visemes[1].offset_ms <= moment_ms:
            self._visemes.popleft()


def _earlier(shapes: Shapes, by_ms: float) -> Shapes:
    visemes = [Viseme(max(0.0, each.offset_ms - by_ms), each.shape, each.weight) for each in shapes.visemes]
    return Shapes(visemes, shapes.until_ms - by_ms)


def _milliseconds(samples: int) -> float:
    return samples * 1000 / SAMPLE_RATE
