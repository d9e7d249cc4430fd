"""From a picture on the link to a picture of the media plane; what is laid out alike is not copied."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source import RawVideo

from openrois_avatar.link.protocol import PixelFormat, Video


def raw_video(video: Video, sequence: int, captured_at: float, *, lent: bool = False) -> RawVideo:
    """The same picture for the media plane.

    BGRA stays a view of the received pixels, also when rows are padded or come bottom-up. I420 stays one when its rows
    are neither padded nor bottom-up; otherwise, and for NV12, the planes are copied into an I420 picture. Pixels that
    are only `lent`, as those in a ring, are copied in any case, and not more than once.
    """
    pixels = np.frombuffer(video.pixels, dtype=np.uint8)
    if video.format is PixelFormat.BGRA:
        rows = pixels.reshape(video.height, video.stride)[:, : video.width * 4]
        picture = _upright(rows, video).reshape(video.height, video.width, 4)
        return RawVideo(picture.copy() if lent else picture, "bgra", video.width, video.height, sequence, captured_at)
    shape = (video.height * 3 // 2, video.width)
    if lent or video.format is PixelFormat.NV12 or video.stride != video.width or video.bottom_up:
        picture = np.empty(shape, np.uint8)
        _copy_planes(video, pixels, picture)
    else:
        picture = pixels.reshape(shape)
    return RawVideo(picture, "i420", video.width, video.height, sequence, captured_at)


def _copy_planes(video: Video, pixels: NDArray[np.uint8], into: NDArray[np.uint8]) -> None:
    """Copy Y, U and V, upright and without padding."""
    width, height, stride = video.width, video.height, video.stride
    luma, chroma = pixels[: stride * height], pixels[stride * height :]
    into[:height] = _upright(luma.reshape(height, stride)[:, :width], video)
    colours = into[height:].reshape(2, height // 2, width // 2)
    if video.format is PixelFormat.NV12:
        pairs = _upright(chroma.reshape(height // 2, stride)[:, :width], video).reshape(height // 2, width // 2, 2)
        # OpenCV takes pairs apart many times faster than NumPy does.
        cv2.split(pairs, list(colours))
    else:
        for plane, colour in zip(chroma.reshape(2, height // 2, stride // 2), colours, strict=True):
            colour[:] = _upright(plane[:, : width // 2], video)


def _upright(rows: NDArray[np.uint8], video: Video) -> NDArray[np.uint8]:
    return rows[::-1] if video.bottom_up else rows
