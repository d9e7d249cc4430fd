"""A game engine's own sound on the media clock: placed by its timestamps, given by the block. Pure."""

from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import SAMPLE_RATE

BLOCK: Final = SAMPLE_RATE // 50
"""Samples of a 20 ms block."""
SEAM: Final = SAMPLE_RATE // 200
"""Samples of a cross-fade, 5 ms."""
APART: Final = SAMPLE_RATE * 3 // 100
"""Samples, 30 ms. A piece that is stamped so close to the end of the one before goes on where that one ended."""
LENGTH: Final = 2 * SAMPLE_RATE
"""Samples from the next one on for which there is room."""

_FOLLOWED: Final = SAMPLE_RATE // 2
"""Samples in which two thirds of a difference between stamps and places are noticed, and of what was noticed undone."""
_UNNOTICED: Final = SAMPLE_RATE // 1000
"""Samples that stamps and places may differ by: how exactly stamps are made."""
_MOST: Final = 50
"""One sample in so many is put in or left out at most: a third of a semitone."""

_RISE: Final = (np.arange(SEAM, dtype=np.float32) + 0.5)[:, np.newaxis] / SEAM
_FALL: Final = 1 - (np.arange(BLOCK, dtype=np.float32) + 0.5)[:, np.newaxis] / BLOCK

Samples = NDArray[np.int16]


class EngineSound:
    """Pieces of any length in, each with the time of its first sample; blocks of 20 ms out, with silence in the gaps.

    What the stamps of successive pieces differ by from the number of their samples is jitter, or a drift between the
    engine's sample clock and ours: the mean is followed by making pieces a little longer or shorter. Where they differ
    by more than `APART`, the piece lies where its stamp says. Sound that comes when its time is over is lost, and moves
    nothing: what is missing dies away within 20 ms, and what comes then fades in.

    Args:
        channels: of what is given, 1 or 2.
    """

    def __init__(self, channels: int) -> None:
        self.late = 0
        """Samples that came when their time was over."""
        self.made_up = 0
        """Samples that were given in the place of missing ones, before the silence."""
        self._channels = channels
        self.start(0)

    def start(self, begin: int) -> None:
        """Forget all sound; sample number `begin` is the next one."""
        self._ring = np.zeros((LENGTH, self._channels), np.int16)
        self._filled = np.zeros(LENGTH, np.bool_)
        self._next = begin
        self._end: int | None = None
        self._apart = 0.0
        """By how many samples the stamps are ahead of the places, on average."""
        self._last = np.zeros((BLOCK, self._channels), np.int16)
        self._dying = self._last[:0]
        self._flowing = False

    def put(self, samples: Samples, at: float) -> int:
        """Take sound of shape (n, 1) or (n, 2), mixed down or doubled if we have another number of channels.

        Args:
            samples: the sound.
            at: when the first sample is to be heard, in seconds.

        Returns:
            The number of the sample where it was placed.
        """
        stamp = round(at * SAMPLE_RATE)
        if self._end is None or abs(stamp - self._end) > APART:
            self._end, self._apart = stamp, 0.0
        first = self._end
        samples = _with_channels(self._followed(samples, stamp - first), self._channels)
        self._end = first + len(samples)
        numbers = np.arange(first, self._end)
        self.late += int(np.count_nonzero(numbers < self._next))
        fits = (numbers >= self._next) & (numbers < self._next + LENGTH)
        numbers, samples = numbers[fits] % LENGTH, samples[fits]
        fresh = ~self._filled[numbers]
        self._ring[numbers[fresh]] = samples[fresh]
        self._filled[numbers] = True
        return first

    def take(self, begin: int) -> Samples:
        """The block, of shape (960, channels), from sample `begin` on; what lies before it is forgotten."""
        skipped = np.arange(self._next, min(begin, self._next + LENGTH)) % LENGTH
        self._filled[skipped] = False
        numbers = np.arange(begin, begin + BLOCK) % LENGTH
        block, there = self._ring[numbers], self._filled[numbers]
        self._filled[numbers] = False
        self._next = begin + BLOCK
        if not (self._flowing and there.all()):
            self._mend(block, there)
        self._last = block
        return block

    def _followed(self, samples: Samples, apart: int) -> Samples:
        """The piece a little longer or shorter, so that stamps and places come together."""
        weight = min(1.0, len(samples) / _FOLLOWED)
        self._apart += weight * (apart - self._apart)
        most = len(samples) // _MOST
        more = max(-most, min(round(self._apart * weight), most))
        if more == 0 or abs(self._apart) < _UNNOTICED:
            return samples
        self._apart -= more
        return _stretched(samples, len(samples) + more)

    def _mend(self, block: Samples, there: NDArray[np.bool_]) -> None:
        """Fill the gaps of a block, and fade in what follows them."""
        edges = [0, *(np.flatnonzero(np.diff(there)) + 1), BLOCK]
        for first, last in pairwise(edges):
            if there[first]:
                if not self._flowing:
                    seam = min(SEAM, last - first)
                    begun = block[first : first + seam] * _RISE[:seam]
                    block[first : first + seam] = np.rint(begun + self._made_up(seam) * (1 - _RISE[:seam]))
                self._flowing = True
            else:
                if self._flowing:
                    before = np.concatenate((self._last, block[:first]))[: -BLOCK - 1 : -1]
                    self._dying = np.rint(before * _FALL).astype(np.int16)
                    self._flowing = False
                block[first:last] = self._made_up(last - first)

    def _made_up(self, count: int) -> Samples:
        """The next samples of what dies away, then silence."""
        part, self._dying = self._dying[:count], self._dying[count:]
        self.made_up += len(part)
        return np.concatenate((part, np.zeros((count - len(part), self._channels), np.int16)))


def _stretched(samples: Samples, count: int) -> Samples:
    """The sound in `count` samples."""
    moments = np.linspace(0, len(samples) - 1, count)
    channels = [np.interp(moments, np.arange(len(samples)), channel) for channel in samples.T]
    return np.asarray(np.rint(np.stack(channels, axis=1)), np.int16)


def _with_channels(samples: Samples, channels: int) -> Samples:
    if samples.shape[1] == channels:
        return samples
    if channels == 2:
        return np.repeat(samples, 2, axis=1)
    return np.asarray(samples.astype(np.int32).sum(axis=1, keepdims=True) // 2, np.int16)
