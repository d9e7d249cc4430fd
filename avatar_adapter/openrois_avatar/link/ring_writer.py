"""The engine's side of the ring: slots in memory that it shares with the adapter, written in turn."""

from __future__ import annotations

import mmap
import os
import threading
from typing import Final

from openrois_avatar.link.messages import SLOT_HEAD, LinkError, RingPlace

_UINT64: Final = 2**64 - 1


class RingWriter:
    """Writes pictures into the ring of a WELCOME, for one thread."""

    def __init__(self, place: RingPlace) -> None:
        """Open the ring.

        Raises:
            LinkError: it cannot be opened, or is smaller than announced.
        """
        self._place = place
        try:
            file = os.open(place.path, os.O_RDWR | os.O_CLOEXEC)
            try:
                self._memory = memoryview(mmap.mmap(file, place.slots * place.slot_bytes))
            finally:
                os.close(file)
        except (OSError, ValueError) as error:
            raise LinkError(
                f"the ring cannot be opened: {error}; run the engine as the adapter's user and in its container"
            ) from error
        self._locks = self._memory.cast("Q")
        self._barrier = threading.Lock()
        self._next = 0

    def write(self, sequence: int, pixels: memoryview) -> int | None:
        """Write a picture into the next slot and return the slot's number; None if it is too large for a slot."""
        begun = self.begin(sequence, len(pixels))
        if begun is None:
            return None
        slot, room = begun
        room[:] = pixels
        self.finish(sequence, slot)
        return slot

    def begin(self, sequence: int, size: int) -> tuple[int, memoryview] | None:
        """Return the next slot, and its memory for a picture of so many bytes, which may be written until `finish`.

        None if it is too large for a slot. A picture that is never finished only invalidates the slot's former one.
        """
        if size > self._place.slot_bytes - SLOT_HEAD:
            return None
        slot, self._next = self._next, (self._next + 1) % self._place.slots
        start = slot * self._place.slot_bytes
        self._locks[start // 8] = (2 * sequence + 1) & _UINT64
        # Taking a lock is the only memory barrier that Python has: the pixels change after the lock word.
        with self._barrier:
            pass
        return slot, self._memory[start + SLOT_HEAD : start + SLOT_HEAD + size]

    def finish(self, sequence: int, slot: int) -> None:
        """Mark the picture as complete in its slot."""
        with self._barrier:
            pass
        self._locks[slot * self._place.slot_bytes // 8] = (2 * sequence + 2) & _UINT64
