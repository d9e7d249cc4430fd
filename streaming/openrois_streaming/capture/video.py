"""Pictures of a camera, a renderer or an encoder as sources."""

from collections.abc import AsyncGenerator, AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, aclosing, asynccontextmanager
from numbers import Integral
from typing import Any, Final, TypeAlias, cast, get_args

import numpy as np
from numpy.typing import NDArray
from openrois_signaling.messages import MediaKind

from openrois_streaming.capture.given import CAMERA_REMEDY, check_function, is_source
from openrois_streaming.capture.iterated import Item, Items, IteratedSource
from openrois_streaming.capture.moments import capture_time
from openrois_streaming.clock import MediaClock, SystemClock
from openrois_streaming.codecs import H264, VP8
from openrois_streaming.rtp.h264_units import access_unit
from openrois_streaming.rtp.vp8_frames import vp8_frame
from openrois_streaming.source.source import EncodedVideo, MediaSource, PixelFormat, RawVideo, picture_shape

Picture: TypeAlias = NDArray[np.uint8] | tuple[NDArray[np.uint8], float]
"""Pixels, as `RawVideo` describes them, alone or with the moment that they show, in seconds of `time.monotonic()`."""
Unit: TypeAlias = bytes | tuple[bytes, float]
"""Encoded picture, as `EncodedVideo` describes it, alone or with the moment that it shows."""

_PICTURES: Final = 2
_UNITS: Final = 60
"""Pictures that may wait while the event loop is busy: raw ones are best when new, encoded ones need each other."""
_MOST_RATE: Final = 1000


class VideoSource:
    """Raw pictures, a `MediaSource[RawVideo]`.

        def pictures():                                  # a generator that blocks is read in a thread of its own
            capture = cv2.VideoCapture(0)
            try:
                while True:
                    yield capture.read()[1]
            finally:
                capture.release()

        VideoSource(pictures, size=(640, 480))

    It is opened while a viewer watches, and only then. What it yields is neither changed nor used again by it.

    Args:
        pictures: a function that returns an iterator of `Picture`, blocking or asynchronous, which has the pace of the
            camera; or a `MediaSource[RawVideo]`, which is taken as it is.
        size: width and height in pixels that are expected; viewers are offered sizes that suit it.
        frame_rate: pictures per second that are expected.
        format: of the pixels.
        clock: the media clock; this machine's if not given.
        name: its name in the log and in errors.

    Raises:
        TypeError: `pictures` is neither a function without arguments nor a source.
        ValueError: no camera has such a size, frame rate or format.
    """

    kind: Final[MediaKind] = "video"

    def __init__(
        self,
        pictures: Items[Picture] | MediaSource[RawVideo],
        *,
        size: tuple[int, int],
        frame_rate: float = 30.0,
        format: PixelFormat = "bgr24",
        clock: MediaClock | None = None,
        name: str = "camera",
    ) -> None:
        _check_expected(size, frame_rate, name)
        if format not in get_args(PixelFormat):
            raise ValueError(f"format of {name} must be one of {', '.join(get_args(PixelFormat))}, not {format!r}")
        picture_shape(format, *size)
        self.size = size
        self.frame_rate = frame_rate
        self._format = format
        self._name = name
        self._source: MediaSource[RawVideo] | IteratedSource[Picture]
        if is_source(pictures):
            self._source = cast("MediaSource[RawVideo]", pictures)
        else:
            check_function(pictures, name, CAMERA_REMEDY)
            items = cast("Items[Picture]", pictures)
            self._source = IteratedSource(items, clock=clock or SystemClock(), depth=_PICTURES, name=name)

    def open(self) -> AbstractAsyncContextManager[AsyncIterator[RawVideo]]:
        """Open the camera; its iterator raises what the camera's raises.

        Raises:
            TypeError, ValueError: (the iterator) a picture has no pixels of this format, or no capture time.
        """
        source = self._source
        return self._read(source) if isinstance(source, IteratedSource) else source.open()

    @asynccontextmanager
    async def _read(self, source: IteratedSource[Picture]) -> AsyncIterator[AsyncIterator[RawVideo]]:
        async with source.open() as items, aclosing(self._frames(items)) as frames:
            yield frames

    async def _frames(self, items: AsyncIterator[Item[Picture]]) -> AsyncGenerator[RawVideo, None]:
        async for item in items:
            pixels, captured_at = capture_time(item.value, item.came_at, self._name)
            width, height = _size_of(pixels, self._format, self._name)
            yield RawVideo(pixels, self._format, width, height, item.number, captured_at)


class EncodedSource:
    """Pictures that a camera or a program encodes itself, an `EncodingSource`: they are sent on as they are.

    All viewers share its one size and bit rate. It should give a key frame every two seconds, or when it is asked for
    one: a viewer that joins sees nothing before. Each key frame of H.264 has its SPS and PPS before it.

    Args:
        units: a function that returns an iterator of `Unit`, blocking or asynchronous.
        size: width and height in pixels that are expected; each key frame says its own.
        mime_type: "video/H264" or "video/VP8".
        frame_rate: pictures per second that are expected.
        request_key_frame: called, in the event loop, when a viewer needs a key frame soon.
        set_bitrate: called, in the event loop, with the bit rate (bit/s) that the viewers' paths carry.
        clock: the media clock; this machine's if not given.
        name: its name in the log and in errors.

    Raises:
        TypeError: `units` is no function without arguments.
        ValueError: the media type is another one, or no camera has such a size or frame rate.
    """

    kind: Final[MediaKind] = "video"

    def __init__(
        self,
        units: Items[Unit],
        *,
        size: tuple[int, int],
        mime_type: str = H264,
        frame_rate: float = 30.0,
        request_key_frame: Callable[[], None] = lambda: None,
        set_bitrate: Callable[[int], None] = lambda _bitrate: None,
        clock: MediaClock | None = None,
        name: str = "camera",
    ) -> None:
        if mime_type not in (H264, VP8):
            raise ValueError(f"pictures of {name} must come encoded as {H264} or {VP8}, not as {mime_type!r}")
        _check_expected(size, frame_rate, name)
        check_function(units, name, "use piped_units for a program that writes encoded pictures")
        self.size = size
        self.mime_type = mime_type
        self.frame_rate = frame_rate
        self._size = size
        self._name = name
        self._request_key_frame = request_key_frame
        self._set_bitrate = set_bitrate
        self._iterated = IteratedSource(units, clock=clock or SystemClock(), depth=_UNITS, name=name)

    @asynccontextmanager
    async def open(self) -> AsyncIterator[AsyncIterator[EncodedVideo]]:
        """Open the camera; its iterator raises what the camera's raises.

        Raises:
            NotPassable: (the iterator) what came is no picture that WebRTC endpoints decode.
            TypeError, ValueError: (the iterator) it is no bytes, or has no capture time.
        """
        async with self._iterated.open() as items, aclosing(self._frames(items)) as frames:
            yield frames

    def request_key_frame(self) -> None:
        """Implement `EncodingSource`."""
        self._request_key_frame()

    def set_bitrate(self, bitrate: int) -> None:
        """Implement `EncodingSource`."""
        self._set_bitrate(bitrate)

    async def _frames(self, items: AsyncIterator[Item[Unit]]) -> AsyncGenerator[EncodedVideo, None]:
        async for item in items:
            data, captured_at = capture_time(item.value, item.came_at, self._name)
            if not isinstance(data, bytes):
                raise TypeError(f"{self._name} must yield encoded pictures as bytes, not {type(data).__name__}")
            picture = access_unit(data) if self.mime_type == H264 else vp8_frame(data)
            self._size = picture.size or self._size
            yield EncodedVideo(data, picture.keyframe, *self._size, item.number, captured_at)


def _check_expected(size: Any, frame_rate: Any, name: str) -> None:
    """Check what is expected of a camera, before a viewer waits for it."""
    sides = isinstance(size, tuple | list) and all(isinstance(side, Integral) and int(side) >= 2 for side in size)
    if not sides or len(size) != 2:
        raise ValueError(f"size of {name} must be a width and height of 2 or more pixels, not {size!r}")
    if not isinstance(frame_rate, int | float) or not 0 < frame_rate <= _MOST_RATE:
        raise ValueError(f"frame_rate of {name} must be pictures per second, up to {_MOST_RATE}, not {frame_rate!r}")


def _size_of(pixels: Any, pixel_format: PixelFormat, name: str) -> tuple[int, int]:
    """Return the width and height of a picture, of which `RawVideo` checks the rest."""
    if not isinstance(pixels, np.ndarray):
        raise TypeError(f"{name} must yield pictures as numpy arrays, not {type(pixels).__name__}")
    planar = pixel_format in ("i420", "nv12")
    if pixels.ndim != (2 if planar else 3):
        shape = "(height * 3 / 2, width)" if planar else "(height, width, channels)"
        raise ValueError(f"{name} must yield {pixel_format} pictures of shape {shape}, not {pixels.shape}")
    return pixels.shape[1], pixels.shape[0] * 2 // 3 if planar else pixels.shape[0]
