"""Memory for pictures, reused for the next picture when no view of it is left: it is warm and mapped already."""

from __future__ import annotations

import weakref
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

KEPT: Final = 8
"""Pictures with memory that is kept; those in use beyond that get memory for once."""
_PAGE: Final = 4096
_PLACE: Final = _PAGE // 2
"""Offset of a picture in its page. Processors copy slowly to an offset that is a few bytes after that of the source in
its own page; data that a socket has received begins at the beginning of a page."""


class _Block(NamedTuple):
    memory: memoryview
    lent: weakref.ref[NDArray[np.uint8]]
    """The last array that was given out; each view of it keeps it alive."""


class PictureMemory:
    """Gives out arrays of bytes to write pictures into, with any content; views may be kept anywhere."""

    def __init__(self) -> None:
        self._blocks: list[_Block] = []

    def allocate(self, size: int) -> NDArray[np.uint8]:
        """Return an array of `size` bytes that is not reused while it, or any view of it, lives."""
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
        """Drop the kept memory; arrays in use stay valid."""
        self._blocks.clear()


def _fresh(size: int) -> memoryview:
    """Return memory that is not cleared first: that would cost as much as receiving a picture."""
    whole = np.empty(size + _PAGE, np.uint8)
    start = (_PLACE - whole.ctypes.data) % _PAGE
    return whole[start : start + size].data
