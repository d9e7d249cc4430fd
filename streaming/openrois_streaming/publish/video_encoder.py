"""H.264 and VP8 for live pictures: one packet for each frame, and key frames only on request."""

from fractions import Fraction
from typing import Any, cast

import av
import cv2
import numpy as np
from av.video.codeccontext import VideoCodecContext
from av.video.frame import PictureType
from numpy.typing import NDArray

from openrois_streaming.adaptation.rung import MAX_BITRATE, MIN_BITRATE
from openrois_streaming.codecs import H264, LIBRARIES
from openrois_streaming.encoded import VIDEO_CLOCK_RATE
from openrois_streaming.publish.encoder import Chunk
from openrois_streaming.rtp.payloads import payloads_of
from openrois_streaming.source.av_frames import planar_frame
from openrois_streaming.source.source import RawVideo

# Seconds of the bit rate that a burst may hold: a larger key frame arrives late, a smaller one is blurred.
_BURST = 0.2
_TIME_BASE = Fraction(1, VIDEO_CLOCK_RATE)
_NO_REGULAR_KEY_FRAMES = 1 << 30

# A longer gap between two frames is a pause of the source and says nothing of its pace.
_PAUSE = 0.5
_PACE_SMOOTHING = 0.1
# Smaller corrections of the bit rate are not worth making.
_TOLERANCE = 0.05
_RESTART_TOLERANCE = 0.1
_RESTART_SHARE = 0.35

_TO_I420 = {
    "bgra": cv2.COLOR_BGRA2YUV_I420,
    "bgr24": cv2.COLOR_BGR2YUV_I420,
    "rgb24": cv2.COLOR_RGB2YUV_I420,
}


class VideoEncoder:
    """Encoder of one rendition with H.264 (`video/H264`) or VP8 (`video/VP8`).

    The size follows the frames, halved `halvings` times: a frame of another size restarts the codec, with a key frame.
    Odd sizes lose their last row or column. `frame_rate` is the pace expected of the source; the bit rate is met at
    another pace too, and is never above `max_bitrate`. For an expected `size` (width and height after halving) the
    codec is opened at once, so that the first picture need not wait for it.

    Raises:
        av.FFmpegError: the codec cannot be opened for this size.
    """

    def __init__(
        self,
        mime_type: str,
        *,
        bitrate: int,
        frame_rate: float,
        max_bitrate: int = 4_000_000,
        halvings: int = 0,
        size: tuple[int, int] | None = None,
    ) -> None:
        self._mime_type = mime_type
        self._frame_rate = frame_rate
        self._max_bitrate = max(MIN_BITRATE, min(max_bitrate, MAX_BITRATE))
        self._halvings = halvings
        self._interval = 1 / frame_rate
        self._bitrate = self._opened_bitrate = self._within_bounds(bitrate)
        self._rate = 0
        self._context: VideoCodecContext | None = None
        self._captured_at: float | None = None
        self._pts = -1
        if size is not None:
            self._context_for(*size)

    def set_bitrate(self, bitrate: int) -> None:
        """Aim at `bitrate` (bit/s), kept within MIN_BITRATE and `max_bitrate`, from the next frame on.

        H.264 follows without a key frame, down to a third of what it started with; below that it starts anew, with one.
        VP8 does if the change is more than a tenth.
        """
        self._bitrate = self._within_bounds(bitrate)

    def encode(self, raw: RawVideo, *, key_frame: bool) -> list[Chunk]:
        """Encode one picture, scaling and colour conversion included.

        Raises:
            av.FFmpegError: the codec cannot be opened for this picture, or has failed.
        """
        pixels = planar(raw, self._halvings)
        context = self._context_for(width=pixels.shape[1], height=pixels.shape[0] * 2 // 3)
        self._keep_pace(raw.captured_at)
        if self._mime_type == H264:
            self._steer(context)
        frame = planar_frame(pixels)
        self._pts = max(round(raw.captured_at * VIDEO_CLOCK_RATE), self._pts + 1)
        frame.pts, frame.time_base = self._pts, _TIME_BASE
        frame.pict_type = PictureType.I if key_frame else PictureType.NONE
        return [self._chunk(packet, raw.captured_at) for packet in context.encode(frame)]

    def _chunk(self, packet: "av.Packet[Any]", captured_at: float) -> Chunk:
        data = bytes(packet)
        return Chunk(data, self._pts, packet.is_keyframe, captured_at, payloads_of(self._mime_type, data))

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
            _prepare_h264(context, self._bitrate, self._max_bitrate, self._frame_rate)
        else:
            _prepare_vp8(context, self._bitrate, self._frame_rate)
        context.open()
        self._context, self._opened_bitrate = context, self._bitrate
        self._rate = self._max_bitrate
        return context

    def _must_restart(self) -> bool:
        """Tell whether the codec must restart to meet the bit rate.

        libvpx accepts no other rate later through FFmpeg; x264 does, but keeps the burst bounds of its start.
        """
        if self._mime_type == H264:
            return self._bitrate < _RESTART_SHARE * self._opened_bitrate
        return abs(self._bitrate - self._opened_bitrate) > _RESTART_TOLERANCE * self._opened_bitrate

    def _keep_pace(self, captured_at: float) -> None:
        if self._captured_at is not None and 0 < captured_at - self._captured_at < _PAUSE:
            self._interval += _PACE_SMOOTHING * (captured_at - self._captured_at - self._interval)
        self._captured_at = captured_at

    def _steer(self, context: VideoCodecContext) -> None:
        """Set the rate of x264, which without delay counts frames and not time, for the pace of the source."""
        rate = min(round(self._bitrate * self._interval * self._frame_rate), self._max_bitrate)
        if abs(rate - self._rate) > _TOLERANCE * self._rate:
            context.bit_rate = self._rate = rate

    def _within_bounds(self, bitrate: int) -> int:
        return max(MIN_BITRATE, min(bitrate, self._max_bitrate))


def planar(raw: RawVideo, halvings: int = 0) -> NDArray[np.uint8]:
    """Return the picture in contiguous I420, its width and height halved so many times, and even.

    An odd row or column is cut off below or on the right.
    """
    # Each halving averages four pixels, which OpenCV does many times faster than any other step; and fewer pixels cost
    # less to convert.
    if raw.format in ("i420", "nv12"):
        data = np.ascontiguousarray(raw.data) if raw.format == "i420" else _sorted_planes(raw)
        width, height = raw.width, raw.height
        for _ in range(halvings):
            data, width, height = _half_i420(data, width, height)
        return data
    pixels: NDArray[np.uint8] = raw.data
    for _ in range(halvings):
        pixels = _half(pixels[: pixels.shape[0] & ~1, : pixels.shape[1] & ~1])
    even = pixels[: pixels.shape[0] & ~1, : pixels.shape[1] & ~1]
    return cast("NDArray[np.uint8]", cv2.cvtColor(even, _TO_I420[raw.format]))


def _sorted_planes(raw: RawVideo) -> NDArray[np.uint8]:
    """Return an NV12 picture in contiguous I420."""
    planes = np.empty((raw.height * 3 // 2, raw.width), np.uint8)
    planes[: raw.height] = raw.data[: raw.height]
    colour = raw.data[raw.height :].reshape(raw.height // 2, raw.width // 2, 2)
    planes.reshape(-1)[raw.width * raw.height :].reshape(2, *colour.shape[:2])[:] = np.moveaxis(colour, 2, 0)
    return planes


def _half(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    height, width = pixels.shape[:2]
    return cast("NDArray[np.uint8]", cv2.resize(pixels, (width // 2, height // 2), interpolation=cv2.INTER_AREA))


def _half_i420(data: NDArray[np.uint8], width: int, height: int) -> tuple[NDArray[np.uint8], int, int]:
    """Return a contiguous I420 picture of half the width and height, and these."""
    even = (width & ~3, height & ~3)
    half = (even[0] // 2, even[1] // 2)
    small = np.empty((half[1] * 3 // 2, half[0]), np.uint8)
    small[: half[1]] = _half(data[: even[1], : even[0]])
    colour = data.reshape(-1)[width * height :].reshape(2, height // 2, width // 2)
    small_colour = small.reshape(-1)[half[0] * half[1] :].reshape(2, half[1] // 2, half[0] // 2)
    for plane, small_plane in zip(colour, small_colour, strict=True):
        small_plane[:] = _half(plane[: even[1] // 2, : even[0] // 2])
    return small, *half


def _prepare_h264(context: VideoCodecContext, bitrate: int, max_bitrate: int, frame_rate: float) -> None:
    # x264 changes its rate while it runs only if it starts at a constant rate, and never above that: start at the
    # highest, and let the first frame lower it.
    context.bit_rate = max_bitrate
    context.options = {
        "preset": "ultrafast",
        "tune": "zerolatency",
        "profile": "baseline",
        "forced-idr": "1",
        "maxrate": str(max_bitrate),
        "bufsize": str(round(max(bitrate * _BURST, max_bitrate / frame_rate))),
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
