"""Raw pictures and sound as PyAV's frames, and pictures in other pixel formats. No OpenCV."""

from fractions import Fraction
from typing import Final, Literal, TypeAlias, cast

import av
import numpy as np
from numpy.typing import NDArray

from openrois_streaming.source.source import SAMPLE_RATE, RawAudio, RawVideo

FrameFormat: TypeAlias = Literal["i420", "rgb24", "bgr24"]
"""Pixel formats that received pictures can be had in."""

VIDEO_CLOCK_RATE: Final = 90_000

_NAMES: Final = {"i420": "yuv420p", "rgb24": "rgb24", "bgr24": "bgr24", "bgra": "bgra"}
_LAYOUTS: Final = {1: "mono", 2: "stereo"}


def picture_frame(raw: RawVideo) -> av.VideoFrame:
    """Return a picture as a frame; it shares the pixels where it can."""
    pixels = np.ascontiguousarray(raw.data)
    if raw.format == "i420" and raw.height % 4:
        # `from_numpy_buffer` rounds such a height down, and takes the wrong rows for colour.
        return av.VideoFrame.from_ndarray(pixels, format=_NAMES[raw.format])
    return av.VideoFrame.from_numpy_buffer(pixels, format=_NAMES[raw.format])


def sound_frame(raw: RawAudio) -> av.AudioFrame:
    """Return a block of sound as a frame, in a copy."""
    samples = np.ascontiguousarray(raw.samples).reshape(1, -1)
    frame = av.AudioFrame.from_ndarray(samples, format="s16", layout=_LAYOUTS[raw.samples.shape[1]])
    frame.sample_rate, frame.time_base = SAMPLE_RATE, Fraction(1, SAMPLE_RATE)
    return frame


def pixels_of(raw: RawVideo, pixel_format: FrameFormat) -> NDArray[np.uint8]:
    """Return the pixels of a picture: those of `raw` where the format is the same, which must not be changed.

    They are uint8 of the shape (height, width, 3) for `rgb24` and `bgr24`, and (height * 3 / 2, width) for `i420`.

    Raises:
        ValueError: there is no such format.
    """
    if pixel_format not in ("i420", "rgb24", "bgr24"):
        raise ValueError(f"{pixel_format!r} is not a format of pictures: use i420, rgb24 or bgr24")
    if raw.format == pixel_format:
        return raw.data
    return cast("NDArray[np.uint8]", picture_frame(raw).to_ndarray(format=_NAMES[pixel_format]))
