"""Memory for pictures: what nobody has a view of any more takes the next one, warm and mapped already."""

from __future__ import annotations

import weakref
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

KEPT: Final = 8
"""Pictures whose memory is kept; those that are in use beyond that have memory of their own, for once."""
_PAGE: Final = 4096
_PLACE: Final = _PAGE // 2
"""Where in a page a picture begins. Processors copy slowly to a place that is a few bytes further in its page than the
source is in its own; what a socket has received begins at the beginning of a page."""


class _Block(NamedTuple):
    memory: memoryview
    lent: weakref.ref[NDArray[np.uint8]]
    """The array that was given out last; whatever is a view of it keeps it alive."""


class PictureMemory:
    """Gives out arrays of bytes to write pictures into. Their content is whatever was there; views may go anywhere."""

    def __init__(self) -> None:
        self._blocks: list[_Block] = []

    def take(self, size: int) -> NDArray[np.uint8]:
        """An array of `size` bytes that is nobody else's for as long as it, or any view of it, lives."""
        memory = None
        for block in list(self._blocks):
            if block.lent() is None and (memory is None or len(block.memory) != size):
                self._blocks.remove(block)
                memory = block.memory if len(block.memory) == size else memory
        memory = _fresh(size) if memory is None else memory
        # Made of a memoryview: NumPy would let views of a part of an array keep only the whole alive.
        array = np.frombuffer(memory, np.uint8)
        if len(self._blocks) < KEPT:
            self._blocks.append(_Block(memory, weakref.ref(array)))
        return array

    def clear(self) -> None:
        """Keep nothing; what is in use stays with those who use it."""
        self._blocks.clear()


def _fresh(size: int) -> memoryview:
    """Memory that is not cleared first: that would cost as much as receiving a picture."""
    whole = np.empty(size + _PAGE, np.uint8)
    start = (_PLACE - whole.ctypes.data) % _PAGE
    return whole[start : start + size].data
