"""Raw pictures and sound as PyAV's frames, and the names of pixel formats."""

from fractions import Fraction
from typing import Final, Literal, TypeAlias

import av
import numpy as np
from numpy.typing import NDArray

from openrois_streaming.source.source import SAMPLE_RATE, RawAudio, RawVideo

FrameFormat: TypeAlias = Literal["i420", "rgb24", "bgr24"]
"""Pixel formats that received pictures can be had in."""

VIDEO_CLOCK_RATE: Final = 90_000

FORMATS: Final = {"i420": "yuv420p", "nv12": "nv12", "rgb24": "rgb24", "bgr24": "bgr24", "bgra": "bgra"}
"""FFmpeg's names of the pixel formats."""

_LAYOUTS: Final = {1: "mono", 2: "stereo"}


def picture_frame(raw: RawVideo) -> av.VideoFrame:
    """Return a picture as a frame; it shares the pixels where it can."""
    pixels = np.ascontiguousarray(raw.data)
    if raw.format == "i420":
        return planar_frame(pixels)
    if raw.format == "nv12":
        return av.VideoFrame.from_ndarray(pixels, format=FORMATS[raw.format])
    return av.VideoFrame.from_numpy_buffer(pixels, format=FORMATS[raw.format])


def planar_frame(pixels: NDArray[np.uint8]) -> av.VideoFrame:
    """Return a contiguous I420 picture, uint8 of shape (height * 3 / 2, width), as a frame."""
    if pixels.shape[0] % 6:
        # `from_numpy_buffer` rounds a height that is no multiple of 4 down, and takes the wrong rows for colour.
        return av.VideoFrame.from_ndarray(pixels, format="yuv420p")
    return av.VideoFrame.from_numpy_buffer(pixels, format="yuv420p")


def sound_frame(raw: RawAudio) -> av.AudioFrame:
    """Return a block of sound as a frame, in a copy."""
    samples = np.ascontiguousarray(raw.samples).reshape(1, -1)
    frame = av.AudioFrame.from_ndarray(samples, format="s16", layout=_LAYOUTS[raw.samples.shape[1]])
    frame.sample_rate, frame.time_base = SAMPLE_RATE, Fraction(1, SAMPLE_RATE)
    return frame
