"""The adapter's side of the ring: sealed shared memory with a few slots for pictures, freed with this process."""

from __future__ import annotations

import fcntl
import mmap
import os
import sys
import threading
from typing import Final

from openrois_avatar.link.media import MAX_VIDEO, Doorbell, PixelFormat, Video, picture_size
from openrois_avatar.link.messages import SLOT_HEAD, LinkError, RingPlace, VideoShape

SLOTS: Final = 4
"""One slot is read, one is written, and two may fill while the adapter is busy."""
_ROW: Final = 256
"""Multiple of bytes to which the rows of a picture may be padded, as by graphics cards."""
_PAGE: Final = 4096
_UINT64: Final = 2**64 - 1
_LATER: Final = 2**63


class Ring:
    """Memory that one engine writes its pictures into and this process reads; `release` it with the connection.

    It is a memory file without a name, which the engine opens through this process's folder in /proc; so it cannot be
    left behind, and only this user can open it. Its size is sealed: no engine can shrink it under a reader.
    """

    def __init__(self, shape: VideoShape) -> None:
        """Allocate a ring for pictures of this shape.

        Raises:
            LinkError: this system, or this shape, does not allow one.
        """
        slot_bytes = _slot_bytes(shape)
        if sys.platform != "linux":
            raise LinkError("a ring needs Linux; on this system pictures go through the socket")
        try:
            self._file = os.memfd_create("openrois-ring", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        except OSError as error:
            raise _no_memory(error) from error
        try:
            os.fchmod(self._file, 0o600)
            os.ftruncate(self._file, SLOTS * slot_bytes)
            fcntl.fcntl(self._file, fcntl.F_ADD_SEALS, fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL)
            self._memory = memoryview(mmap.mmap(self._file, SLOTS * slot_bytes, access=mmap.ACCESS_READ))
        except OSError as error:
            os.close(self._file)
            raise _no_memory(error) from error
        self._locks = self._memory.cast("Q")
        self._barrier = threading.Lock()
        self.place = RingPlace(f"/proc/{os.getpid()}/fd/{self._file}", SLOTS, slot_bytes)

    def release(self) -> None:
        """Close the file, so that the engine cannot open it any more; the last picture in it frees the memory."""
        if self._file >= 0:
            os.close(self._file)
            self._file = -1

    def picture(self, bell: Doorbell) -> Video | None:
        """Return the picture of a doorbell, its pixels still in the ring; None if a later picture has overwritten it.

        Raises:
            LinkError: there is no such slot, the picture is larger than one, or it has not been written there.
        """
        if bell.slot >= self.place.slots:
            raise LinkError(f"RING: slot {bell.slot} of {self.place.slots}; count them from 0")
        if bell.size > self.place.slot_bytes - SLOT_HEAD:
            raise LinkError(
                f"RING: {bell.size} bytes of pixels do not fit a slot of {self.place.slot_bytes}; send them as VIDEO"
            )
        lead = (self._lock(bell) - _written(bell)) & _UINT64
        if lead >= _LATER:
            raise LinkError(
                f"RING: picture {bell.sequence} is not in slot {bell.slot}: its lock word is {self._lock(bell)} "
                f"and should be {_written(bell)}; write the pixels and then the lock word before RING is sent"
            )
        if lead:
            return None
        start = bell.slot * self.place.slot_bytes + SLOT_HEAD
        shape = bell.sequence, bell.timestamp_ns, bell.width, bell.height, bell.stride, bell.format
        return Video(*shape, self._memory[start : start + bell.size], bell.bottom_up)

    def is_whole(self, bell: Doorbell) -> bool:
        """Return whether the bytes that were read until now are all of this picture."""
        # Taking a lock is the only memory barrier that Python has: earlier reads are not moved behind it.
        with self._barrier:
            pass
        return self._lock(bell) == _written(bell)

    def _lock(self, bell: Doorbell) -> int:
        # Eight bytes in one load, which `struct` would make of eight.
        return self._locks[bell.slot * self.place.slot_bytes // 8]


def _no_memory(error: OSError) -> LinkError:
    return LinkError(f"there is no memory for a ring: {error}; pictures go through the socket")


def _written(bell: Doorbell) -> int:
    """Return the lock word of a slot that holds the picture of this doorbell."""
    return (2 * bell.sequence + 2) & _UINT64


def _slot_bytes(shape: VideoShape) -> int:
    pixel_format = PixelFormat.__members__.get(shape.format.upper())
    if pixel_format is None:
        raise LinkError("encoded pictures need no ring: they go through the socket")
    row = shape.width * (4 if pixel_format is PixelFormat.BGRA else 1)
    size = picture_size(shape.width, shape.height, _up(row, _ROW), pixel_format)
    return min(_up(SLOT_HEAD + size, _PAGE), MAX_VIDEO)


def _up(number: int, step: int) -> int:
    return -(-number // step) * step
