"""Decoders of what applications send: H.264, VP8 and Opus; errors of a decoder stay here."""

from typing import cast

import av
import numpy as np
from av.audio.codeccontext import AudioCodecContext
from av.codec.context import Flags
from av.video.codeccontext import VideoCodecContext
from av.video.reformatter import ColorRange
from numpy.typing import NDArray

from openrois_streaming.codecs import H264, LIBRARIES, OPUS, VP8
from openrois_streaming.receive.playout import BLOCK, UndecodableSound
from openrois_streaming.receive.stretch import Samples
from openrois_streaming.source.source import SAMPLE_RATE

DECODERS = {H264: "h264", VP8: "vp8"}
"""Media type of each codec that can be decoded, and FFmpeg's decoder for it."""

PIXELS_LIMIT = 3840 * 2160
"""Larger pictures are refused: their size is announced before their data has come."""

_FULL_RANGE = "yuvj420p"
_I420 = "yuv420p"


class UndecodablePicture(ValueError):
    """Picture that the decoder has refused; the next one it can decode is a key frame."""


class VideoDecoder:
    """Decoder of the pictures of one source. All calls come from one thread."""

    def __init__(self, mime_type: str) -> None:
        self._name = DECODERS[mime_type]
        self._context = self._open()

    def decode(self, data: bytes) -> list[av.VideoFrame]:
        """Decode `data` into no picture or one, in I420 of limited range; an odd row or column is left out.

        Raises:
            UndecodablePicture: it cannot be decoded; the decoder restarts.
        """
        try:
            return [usual(frame) for frame in self._context.decode(av.Packet(data))]
        except (av.FFmpegError, ValueError, MemoryError) as error:
            self._context = self._open()
            raise UndecodablePicture(str(error)) from error

    def _open(self) -> VideoCodecContext:
        context = cast(VideoCodecContext, av.CodecContext.create(self._name, "r"))
        context.thread_count = 1
        context.flags |= Flags.low_delay
        context.options = {"max_pixels": str(PIXELS_LIMIT)}
        return context


def usual(frame: av.VideoFrame) -> av.VideoFrame:
    """Return a decoded picture in I420 of limited range, width and height even: mostly the frame itself."""
    width, height = frame.width & ~1, frame.height & ~1
    full_range = frame.format.name == _FULL_RANGE or frame.color_range == ColorRange.JPEG
    if (width, height) != (frame.width, frame.height) or full_range or frame.format.name != _I420:
        source = ColorRange.JPEG if full_range else ColorRange.MPEG
        return frame.reformat(width, height, _I420, src_color_range=source, dst_color_range=ColorRange.MPEG)
    return frame


def planes_of(frame: av.VideoFrame) -> NDArray[np.uint8]:
    """Copy the pixels of a decoded picture: uint8 of shape (height * 3 / 2, width), limited range."""
    return cast("NDArray[np.uint8]", usual(frame).to_ndarray())


# An empty frame of 10 ms (RFC 6716 section 3.1) makes the decoder conceal a loss.
_TEN_MILLISECONDS, _STEREO = 0xF0, 0x04


class OpusDecoder:
    """Decoder of the sound packets of one source, in stereo. All calls come from one thread."""

    def __init__(self) -> None:
        self._context = self._open()
        self._stereo = 0

    def decode(self, payload: bytes) -> Samples:
        """Decode a packet of 2.5 to 120 ms.

        Raises:
            UndecodableSound: it cannot be decoded.
        """
        if not payload:
            raise UndecodableSound("an empty packet")
        samples = self._run(payload)
        self._stereo = payload[0] & _STEREO
        return samples

    def conceal(self) -> Samples:
        """Return 10 ms that continue the sound, and fade away after a while."""
        try:
            return self._run(bytes([_TEN_MILLISECONDS | self._stereo]))
        except UndecodableSound:
            return np.zeros((BLOCK, 2), np.int16)

    def _run(self, payload: bytes) -> Samples:
        try:
            decoded = [_samples_of(frame) for frame in self._context.decode(av.Packet(payload))]
        except (av.FFmpegError, ValueError) as error:
            raise UndecodableSound(str(error)) from error
        if not decoded:
            raise UndecodableSound("a packet without sound")
        return decoded[0] if len(decoded) == 1 else np.concatenate(decoded)

    def _open(self) -> AudioCodecContext:
        context = cast(AudioCodecContext, av.CodecContext.create(LIBRARIES[OPUS], "r"))
        context.format, context.layout, context.sample_rate = "s16", "stereo", SAMPLE_RATE
        return context


def _samples_of(frame: av.AudioFrame) -> Samples:
    """Return the samples of a packed frame in the frame's own memory, which `to_ndarray` would copy twice."""
    return np.ndarray((frame.samples, 2), np.int16, buffer=memoryview(frame.planes[0]))
