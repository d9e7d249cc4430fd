"""Decoded pictures, copied into arrays only when, and as, they are read."""

import sys
from typing import Final, cast

import av
import numpy as np
from av.video.reformatter import VideoReformatter
from numpy.typing import NDArray

from openrois_streaming.receive.remote_time import CaptureTime
from openrois_streaming.source.av_frames import FORMATS, FrameFormat
from openrois_streaming.source.source import ReceivedVideo

_KEPT: Final = 4
"""Arrays of a pool: one that is read, one that waits, and those of another reader."""

_UNUSED: Final = 2
"""References that an array of the pool has itself: the list's, and the one that asks."""


class DecodedPicture:
    """Picture as its decoder gave it, in I420 of limited range, width and height even; for one event loop.

    Attributes:
        width: in pixels.
        height: in pixels.
        captured_at: as in `ReceivedVideo`.
        reported_at: as in `ReceivedVideo`.
    """

    __slots__ = ("_arrays", "_frame", "_pool", "_sequence", "captured_at", "height", "reported_at", "width")

    def __init__(self, frame: av.VideoFrame, sequence: int, captured: CaptureTime, pool: "PixelPool") -> None:
        self.width, self.height = frame.width, frame.height
        self.captured_at, self.reported_at = captured
        self._frame = frame
        self._sequence = sequence
        self._pool = pool
        self._arrays: dict[FrameFormat, NDArray[np.uint8]] = {}

    def pixels(self, pixel_format: FrameFormat) -> NDArray[np.uint8]:
        """Return the pixels; all readers get the same array.

        They are uint8 of the shape (height, width, 3) for `rgb24` and `bgr24`, and (height * 3 / 2, width) for `i420`.
        """
        if pixel_format not in self._arrays:
            planar = pixel_format == "i420"
            array = self._frame.to_ndarray() if planar else self._packed(FORMATS[pixel_format])
            self._arrays[pixel_format] = cast("NDArray[np.uint8]", array)
        return self._arrays[pixel_format]

    def raw(self) -> ReceivedVideo:
        """Return the picture as a raw one, in I420."""
        times = (self._sequence, self.captured_at, self.reported_at)
        return ReceivedVideo(self.pixels("i420"), "i420", self.width, self.height, *times)

    def _packed(self, name: str) -> NDArray[np.uint8]:
        """Return the pixels in a format of three bytes each."""
        array = self._pool.array((self.height, self.width, 3))
        plane = self._pool.reformatter.reformat(self._frame, format=name, threads=1).planes[0]
        row = 3 * self.width
        # Rows are padded; as rows of bytes they are copied at once, as pixels one by one.
        rows = np.ndarray((self.height, row), np.uint8, buffer=memoryview(plane), strides=(plane.line_size, 1))
        array.reshape(self.height, row)[...] = rows
        return array


class PixelPool:
    """Arrays of pictures, used again when no reader has them, or a view of them, any more.

    An array of 720p is so large that the allocator would give its memory back to the system with each picture, and
    clearing it anew takes longer than the conversion. For one event loop.

    Attributes:
        reformatter: converts pictures; to make one for each takes half as long as the conversion.
    """

    def __init__(self) -> None:
        self.reformatter = VideoReformatter()
        self._arrays: list[NDArray[np.uint8]] = []

    def array(self, shape: tuple[int, ...]) -> NDArray[np.uint8]:
        """Return an array of arbitrary content."""
        self._arrays = [each for each in self._arrays if each.shape == shape]
        for index in range(len(self._arrays)):
            if sys.getrefcount(self._arrays[index]) <= _UNUSED:
                return self._arrays[index]
        array = np.empty(shape, np.uint8)
        if len(self._arrays) < _KEPT:
            self._arrays.append(array)
        return array


class DecodedPictures:
    """Maker of the pictures of one section, which share a pool."""

    def __init__(self) -> None:
        self._pool = PixelPool()

    def __call__(self, frame: av.VideoFrame, sequence: int, captured: CaptureTime) -> DecodedPicture:
        """Return a decoded frame as a picture; callable from any thread."""
        return DecodedPicture(frame, sequence, captured, self._pool)
