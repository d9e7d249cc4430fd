"""H.264 and VP8 for live pictures: one packet out for each frame in, and a key frame only when one is asked for."""

from fractions import Fraction
from typing import cast

import av
import cv2
import numpy as np
from av.video.codeccontext import VideoCodecContext
from av.video.frame import PictureType
from numpy.typing import NDArray

from openrois_streaming.codecs import H264, LIBRARIES
from openrois_streaming.encoded import VIDEO_CLOCK_RATE
from openrois_streaming.encoder import Chunk
from openrois_streaming.source import RawVideo

MIN_BITRATE = 50_000
MAX_BITRATE = 4_000_000
"""Bounds of a video rendition in bit/s."""

# Seconds of the bit rate that a burst may hold: a larger key frame arrives late, a smaller one is blurred.
_BURST = 0.3
_TIME_BASE = Fraction(1, VIDEO_CLOCK_RATE)
_NO_REGULAR_KEY_FRAMES = 1 << 30

# A longer gap between two frames is a pause of the source and says nothing of its pace.
_PAUSE = 0.5
_PACE_SMOOTHING = 0.1
# Smaller corrections of the bit rate are not worth making.
_TOLERANCE = 0.05
_RESTART_TOLERANCE = 0.1


class VideoEncoder:
    """Encodes the frames of one rendition with H.264 (`video/H264`) or VP8 (`video/VP8`).

    The size follows the frames: a frame of another size starts the codec anew, with a key frame. Odd sizes lose their
    last row or column. `frame_rate` is the pace expected of the source; the bit rate is met at another pace too.
    """

    def __init__(self, mime_type: str, *, bitrate: int, frame_rate: float) -> None:
        self._mime_type = mime_type
        self._frame_rate = frame_rate
        self._interval = 1 / frame_rate
        self._bitrate = self._opened_bitrate = within_bounds(bitrate)
        self._rate = 0
        self._context: VideoCodecContext | None = None
        self._captured_at: float | None = None
        self._pts = -1

    def set_bitrate(self, bitrate: int) -> None:
        """Aim at `bitrate` (bit/s), kept within MIN_BITRATE and MAX_BITRATE, from the next frame on.

        H.264 follows without a key frame. VP8 starts anew, with one, if the change is more than a tenth.
        """
        self._bitrate = within_bounds(bitrate)

    def encode(self, raw: RawVideo, *, key_frame: bool) -> list[Chunk]:
        """Encode one picture, colour conversion included.

        Raises:
            av.FFmpegError: the codec cannot be opened for this picture, or has failed.
        """
        pixels = planar(raw)
        context = self._context_for(width=pixels.shape[1], height=pixels.shape[0] * 2 // 3)
        self._keep_pace(raw.captured_at)
        if self._mime_type == H264:
            self._steer(context)
        frame = av.VideoFrame.from_numpy_buffer(pixels, format="yuv420p")
        self._pts = max(round(raw.captured_at * VIDEO_CLOCK_RATE), self._pts + 1)
        frame.pts, frame.time_base = self._pts, _TIME_BASE
        frame.pict_type = PictureType.I if key_frame else PictureType.NONE
        return [
            Chunk(bytes(packet), self._pts, packet.is_keyframe, raw.captured_at) for packet in context.encode(frame)
        ]

    def _context_for(self, width: int, height: int) -> VideoCodecContext:
        context = self._context
        if context is not None and (context.width, context.height) == (width, height) and not self._must_restart():
            return context
        context = cast(VideoCodecContext, av.CodecContext.create(LIBRARIES[self._mime_type], "w"))
        context.width, context.height, context.pix_fmt = width, height, "yuv420p"
        context.time_base = _TIME_BASE
        context.framerate = Fraction(self._frame_rate).limit_denominator(1001)
        context.gop_size = _NO_REGULAR_KEY_FRAMES
        context.thread_count = 1
        if self._mime_type == H264:
            _prepare_h264(context, self._bitrate, self._frame_rate)
        else:
            _prepare_vp8(context, self._bitrate, self._frame_rate)
        context.open()
        self._context, self._opened_bitrate = context, self._bitrate
        self._rate = MAX_BITRATE
        return context

    def _must_restart(self) -> bool:
        """Whether the bit rate cannot be reached as the codec is: libvpx takes none later through FFmpeg."""
        change = abs(self._bitrate - self._opened_bitrate) / self._opened_bitrate
        return self._mime_type != H264 and change > _RESTART_TOLERANCE

    def _keep_pace(self, captured_at: float) -> None:
        if self._captured_at is not None and 0 < captured_at - self._captured_at < _PAUSE:
            self._interval += _PACE_SMOOTHING * (captured_at - self._captured_at - self._interval)
        self._captured_at = captured_at

    def _steer(self, context: VideoCodecContext) -> None:
        """Give x264, which without delay counts frames and not time, the rate that makes the right one at this pace."""
        rate = min(round(self._bitrate * self._interval * self._frame_rate), MAX_BITRATE)
        if abs(rate - self._rate) > _TOLERANCE * self._rate:
            context.bit_rate = self._rate = rate


def within_bounds(bitrate: int) -> int:
    """`bitrate`, or the nearest one that a video rendition can have."""
    return max(MIN_BITRATE, min(bitrate, MAX_BITRATE))


def planar(raw: RawVideo) -> NDArray[np.uint8]:
    """The picture in contiguous I420, without its last row or column where their number is odd."""
    if raw.format == "i420":
        return np.ascontiguousarray(raw.data)
    even = raw.data[: raw.height & ~1, : raw.width & ~1]
    code = cv2.COLOR_BGRA2YUV_I420 if raw.format == "bgra" else cv2.COLOR_BGR2YUV_I420
    return cast("NDArray[np.uint8]", cv2.cvtColor(even, code))


def _prepare_h264(context: VideoCodecContext, bitrate: int, frame_rate: float) -> None:
    # x264 changes its rate while it runs only if it starts at a constant one, and then never above that one: start at
    # the highest, and let the first frame take it down.
    context.bit_rate = MAX_BITRATE
    context.options = {
        "preset": "ultrafast",
        "tune": "zerolatency",
        "profile": "baseline",
        "forced-idr": "1",
        "maxrate": str(MAX_BITRATE),
        "bufsize": str(round(max(bitrate * _BURST, MAX_BITRATE / frame_rate))),
    }


def _prepare_vp8(context: VideoCodecContext, bitrate: int, frame_rate: float) -> None:
    context.bit_rate = bitrate
    context.qmin, context.qmax = 2, 56
    context.options = {
        "deadline": "realtime",
        "cpu-used": "-8",
        "lag-in-frames": "0",
        "auto-alt-ref": "0",
        "noise-sensitivity": "0",
        "error-resilient": "0",
        "static-thresh": "1",
        # Equal bounds are libvpx's constant bit rate.
        "minrate": str(bitrate),
        "maxrate": str(bitrate),
        "bufsize": str(round(bitrate * 2 * _BURST)),
        "undershoot-pct": "100",
        "overshoot-pct": "15",
        # In per cent of what one frame has on average.
        "max-intra-rate": str(round(100 * _BURST * frame_rate)),
    }
