"""A game engine's own sound on the media clock: placed by its timestamps, given by the block, delayed if late. Pure."""

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
"""Samples, 30 ms. A piece with a stamp so close to the end of the last piece continues it."""
LENGTH: Final = 2 * SAMPLE_RATE
"""Capacity in samples, from the next one on."""

LONGEST_LAG: Final = 0.25
"""The longest delay in seconds; sound that is later is lost."""
LAG_MEMORY: Final = 2.0
"""Seconds for which the latest sound is remembered at least; twice as long at most."""
LAG_MARGIN: Final = 0.003
"""Seconds by which the latest one may be exceeded before something is lost."""

_NEVER: Final = float("-inf")
_FOLLOWED: Final = SAMPLE_RATE // 2
"""Samples in which two thirds of a difference between stamps and places are detected, and then corrected."""
_UNNOTICED: Final = SAMPLE_RATE // 1000
"""Samples by which stamps and places may differ: the precision of stamps."""
_MOST: Final = 50
"""At most one sample in so many is inserted or left out: a third of a semitone."""

_RISE: Final = (np.arange(SEAM, dtype=np.float32) + 0.5)[:, np.newaxis] / SEAM
_FALL: Final = 1 - (np.arange(BLOCK, dtype=np.float32) + 0.5)[:, np.newaxis] / BLOCK

Samples = NDArray[np.int16]


class EngineSound:
    """A buffer: pieces of any length in, each with the time of its first sample; blocks of 20 ms out, gaps silent.

    A difference between the stamps of successive pieces and the number of their samples is jitter, or a drift between
    the engine's sample clock and ours: the mean is followed by making pieces a little longer or shorter. Where they
    differ by more than `APART`, the piece lies where its stamp says. Sound that comes too late is lost, and moves
    nothing: before a gap the sound fades out within 20 ms, after it the sound fades in.

    Args:
        channels: of the blocks, 1 or 2.
    """

    def __init__(self, channels: int) -> None:
        self.late = 0
        """Samples that came too late."""
        self.made_up = 0
        """Samples of fade-outs in the place of missing ones."""
        self._channels = channels
        self.start(0)

    def start(self, begin: int) -> None:
        """Drop all sound; sample number `begin` is the next one."""
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
        """Add sound of shape (n, 1) or (n, 2), mixed down or doubled for another number of channels.

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

    def next_block(self, begin: int) -> Samples:
        """Return the block, of shape (960, channels), from sample `begin` on, and drop the sound before it."""
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
        """Return the piece a little longer or shorter, so that stamps and places converge."""
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
        """Return the next samples of the fade-out, then silence."""
        part, self._dying = self._dying[:count], self._dying[count:]
        self.made_up += len(part)
        return np.concatenate((part, np.zeros((count - len(part), self._channels), np.int16)))


class SoundLag:
    """The delay of the mixed sound for an engine that sends its own sound late; 0 for one that sends it ahead of time.

    A block is given out `seconds` after the moment of its first sample. Its timestamp stays the same, so that pictures
    wait as long.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self._latest = self._before = _NEVER
        self._since = _NEVER

    def arrived(self, late: float, now: float) -> None:
        """Note sound that came at `now`, `late` seconds after the moment of its block; before it if negative."""
        if now - self._since >= LAG_MEMORY:
            gone = now - self._since >= 2 * LAG_MEMORY
            self._before = _NEVER if gone else self._latest
            self._latest, self._since = _NEVER, now
        self._latest = max(self._latest, late)
        self.seconds = min(max(0.0, max(self._latest, self._before) + LAG_MARGIN), LONGEST_LAG)


def _stretched(samples: Samples, count: int) -> Samples:
    """Return the sound resampled to `count` samples."""
    moments = np.linspace(0, len(samples) - 1, count)
    channels = [np.interp(moments, np.arange(len(samples)), channel) for channel in samples.T]
    return np.asarray(np.rint(np.stack(channels, axis=1)), np.int16)


def _with_channels(samples: Samples, channels: int) -> Samples:
    if samples.shape[1] == channels:
        return samples
    if channels == 2:
        return np.repeat(samples, 2, axis=1)
    return np.asarray(samples.astype(np.int32).sum(axis=1, keepdims=True) // 2, np.int16)
