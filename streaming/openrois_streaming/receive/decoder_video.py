"""H.264 and VP8 from the network: one picture out for each one in, and errors that stay here."""

from typing import cast

import av
import numpy as np
from av.codec.context import Flags
from av.video.codeccontext import VideoCodecContext
from av.video.reformatter import ColorRange
from numpy.typing import NDArray

from openrois_streaming.codecs import H264, VP8

DECODERS = {H264: "h264", VP8: "vp8"}
"""Media type of each codec that can be decoded, and FFmpeg's decoder for it."""

PIXELS_LIMIT = 3840 * 2160
"""A larger picture is refused: its sender says how large it is before anything of it has come."""

_FULL_RANGE = "yuvj420p"
_I420 = "yuv420p"


class UndecodablePicture(ValueError):
    """The decoder has refused a picture; the next one that it can take is a key frame."""


class VideoDecoder:
    """Decodes the pictures of one source. All calls come from one thread."""

    def __init__(self, mime_type: str) -> None:
        self._name = DECODERS[mime_type]
        self._context = self._open()

    def decode(self, data: bytes) -> list[NDArray[np.uint8]]:
        """The pictures in `data`, none or one, in I420 as `RawVideo` has it; an odd row or column is left out.

        Raises:
            UndecodablePicture: it cannot be decoded; the decoder begins anew.
        """
        try:
            return [planes_of(frame) for frame in self._context.decode(av.Packet(data))]
        except (av.FFmpegError, ValueError, MemoryError) as error:
            self._context = self._open()
            raise UndecodablePicture(str(error)) from error

    def _open(self) -> VideoCodecContext:
        context = cast(VideoCodecContext, av.CodecContext.create(self._name, "r"))
        context.thread_count = 1
        context.flags |= Flags.low_delay
        context.options = {"max_pixels": str(PIXELS_LIMIT)}
        return context


def planes_of(frame: av.VideoFrame) -> NDArray[np.uint8]:
    """The pixels of a decoded picture, copied: uint8 of shape (height * 3 / 2, width), limited range."""
    width, height = frame.width & ~1, frame.height & ~1
    full_range = frame.format.name == _FULL_RANGE or frame.color_range == ColorRange.JPEG
    if (width, height) != (frame.width, frame.height) or full_range or frame.format.name != _I420:
        source = ColorRange.JPEG if full_range else ColorRange.MPEG
        frame = frame.reformat(width, height, _I420, src_color_range=source, dst_color_range=ColorRange.MPEG)
    return cast("NDArray[np.uint8]", frame.to_ndarray())
