"""A small buffer between a game engine's sound and the media clock: takes what comes, gives a block when one is due."""

from __future__ import annotations

from collections import deque
from typing import Final

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source import SAMPLE_RATE

BLOCK: Final = SAMPLE_RATE // 50
"""Samples of a 20 ms block."""
TARGET_BLOCKS: Final = 3
"""Blocks that are waited for before sound starts: an engine that sends with each picture sends bursts of 40 ms."""
LIMIT_BLOCKS: Final = 12
"""More than these are never kept."""
SEAM: Final = SAMPLE_RATE // 200
"""Samples of a cross-fade, 5 ms."""
_PATIENCE: Final = 50
"""Blocks over which the level must stay too high before it counts as drift: a second."""

_RISE: Final = (np.arange(SEAM, dtype=np.float32) + 0.5)[:, np.newaxis] / SEAM


class JitterBuffer:
    """Evens out bursts, and the drift between the engine's clock and ours. Not for use by several threads.

    When the engine is slower the block that was given last is given once more, when it is faster one is left out, both
    with a cross-fade; after a longer gap, and before the first sound, there is silence until `TARGET_BLOCKS` are there.
    `repeated`, `left_out` and `overflowed` count the blocks.
    """

    def __init__(self, channels: int) -> None:
        self.repeated = 0
        self.left_out = 0
        self.overflowed = 0
        self._channels = channels
        self.clear()

    def clear(self) -> None:
        """Forget everything but the counters."""
        self._pieces: deque[NDArray[np.int16]] = deque()
        self._level = 0
        self._last = self._silence()
        self._flowing = False
        self._stretched = False
        self._torn = False
        self._lowest = LIMIT_BLOCKS * BLOCK
        self._since = 0

    def put(self, samples: NDArray[np.int16]) -> None:
        """Take sound of shape (n, 1) or (n, 2); it is mixed down or doubled if we have another number of channels."""
        self._pieces.append(_with_channels(samples, self._channels))
        self._level += len(samples)
        if self._level > LIMIT_BLOCKS * BLOCK:
            surplus = (self._level - TARGET_BLOCKS * BLOCK) // BLOCK
            self._cut_off(surplus * BLOCK)
            self.overflowed += surplus
            self._torn = True

    def take(self) -> NDArray[np.int16]:
        """The next block, of shape (960, channels)."""
        block, seam = self._next()
        self._last = _joined(self._last, block) if seam else block
        return self._last

    def _next(self) -> tuple[NDArray[np.int16], bool]:
        """The next block, and whether it does not continue the last one."""
        if not self._flowing:
            if self._level < TARGET_BLOCKS * BLOCK:
                return self._silence(), True
            self._flowing = self._torn = True
        if self._level < BLOCK:
            return self._bridge(), True
        self._stretched = False
        seam, self._torn = self._torn, False
        block = self._cut_off(BLOCK)
        if self._runs_ahead():
            self.left_out += 1
            block = _cross_faded(block, self._cut_off(BLOCK))
        return block, seam

    def _bridge(self) -> NDArray[np.int16]:
        """What to give when there is nothing: the last block once more, then silence until there is enough again."""
        if self._stretched:
            self._flowing = self._stretched = False
            return self._silence()
        self._stretched = True
        self.repeated += 1
        return self._last

    def _runs_ahead(self) -> bool:
        """Whether more than the target was there at every moment of the last second."""
        self._lowest = min(self._lowest, self._level)
        self._since += 1
        if self._since < _PATIENCE:
            return False
        ahead = self._lowest > TARGET_BLOCKS * BLOCK
        self._lowest, self._since = LIMIT_BLOCKS * BLOCK, 0
        return ahead

    def _cut_off(self, count: int) -> NDArray[np.int16]:
        """Remove `count` samples from the front; there must be as many."""
        self._level -= count
        parts: list[NDArray[np.int16]] = []
        while count:
            piece = self._pieces.popleft()
            if len(piece) > count:
                self._pieces.appendleft(piece[count:])
                piece = piece[:count]
            parts.append(piece)
            count -= len(piece)
        return np.concatenate(parts)

    def _silence(self) -> NDArray[np.int16]:
        return np.zeros((BLOCK, self._channels), np.int16)


def _joined(last: NDArray[np.int16], block: NDArray[np.int16]) -> NDArray[np.int16]:
    """`block`, its beginning faded over from what `last` would do if it went back the way it came."""
    joined = block.copy()
    joined[:SEAM] = np.rint(last[: -SEAM - 1 : -1] * (1 - _RISE) + block[:SEAM] * _RISE)
    return joined


def _cross_faded(first: NDArray[np.int16], second: NDArray[np.int16]) -> NDArray[np.int16]:
    """A block that begins as `first` and ends as `second`."""
    before, after = (BLOCK - SEAM) // 2, (BLOCK + SEAM) // 2
    middle = np.rint(first[before:after] * (1 - _RISE) + second[before:after] * _RISE).astype(np.int16)
    return np.concatenate([first[:before], middle, second[after:]])


def _with_channels(samples: NDArray[np.int16], channels: int) -> NDArray[np.int16]:
    if samples.shape[1] == channels:
        return samples
    if channels == 2:
        return np.repeat(samples, 2, axis=1)
    return np.asarray(samples.astype(np.int32).sum(axis=1, keepdims=True) // 2, np.int16)
