"""From a picture on the link to a picture of the media plane; what is laid out alike is not copied."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source import RawVideo

from openrois_avatar.link.protocol import PixelFormat, Video


def raw_video(video: Video, sequence: int, captured_at: float) -> RawVideo:
    """The same picture for the media plane.

    BGRA stays a view of the received pixels, also when rows are padded or come bottom-up. I420 stays one when its rows
    are neither padded nor bottom-up; otherwise, and for NV12, the planes are copied into an I420 picture.
    """
    pixels = np.frombuffer(video.pixels, dtype=np.uint8)
    if video.format is PixelFormat.BGRA:
        rows = pixels.reshape(video.height, video.stride)[:, : video.width * 4]
        picture = _upright(rows, video).reshape(video.height, video.width, 4)
        return RawVideo(picture, "bgra", video.width, video.height, sequence, captured_at)
    if video.format is PixelFormat.NV12 or video.stride != video.width or video.bottom_up:
        pixels = np.concatenate([plane.reshape(-1) for plane in _planes(video, pixels)])
    data = pixels.reshape(video.height * 3 // 2, video.width)
    return RawVideo(data, "i420", video.width, video.height, sequence, captured_at)


def _planes(video: Video, pixels: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    """Y, U and V, upright and without padding."""
    width, height, stride = video.width, video.height, video.stride
    luma, chroma = pixels[: stride * height], pixels[stride * height :]
    if video.format is PixelFormat.NV12:
        pairs = chroma.reshape(height // 2, stride)[:, :width]
        colours = [pairs[:, 0::2], pairs[:, 1::2]]
    else:
        colours = [plane[:, : width // 2] for plane in chroma.reshape(2, height // 2, stride // 2)]
    return [_upright(plane, video) for plane in (luma.reshape(height, stride)[:, :width], *colours)]


def _upright(rows: NDArray[np.uint8], video: Video) -> NDArray[np.uint8]:
    return rows[::-1] if video.bottom_up else rows
