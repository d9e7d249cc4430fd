"""Conversion of a picture of the link to one of the media plane, without a copy where the layouts agree."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import cv2
import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import RawVideo

from openrois_avatar.link.protocol import PixelFormat, Video

Room: TypeAlias = Callable[[int], NDArray[np.uint8]]
"""Returns an array for so many bytes."""


def _fresh(size: int) -> NDArray[np.uint8]:
    return np.empty(size, np.uint8)


def raw_video(
    video: Video,
    sequence: int,
    captured_at: float,
    room: Room = _fresh,
    *,
    lent: bool = False,
) -> RawVideo:
    """Return the picture for the media plane.

    BGRA stays a view of the received pixels, also when rows are padded or come bottom-up. I420 stays a view when its
    rows are neither padded nor bottom-up, and so does NV12 where the pixels can be written to: its chroma is reordered
    in place. Otherwise the planes are copied into an I420 picture, in an array of `room`. Pixels that are only `lent`,
    as those in a ring, are copied in any case, and not more than once.
    """
    pixels = np.frombuffer(video.pixels, dtype=np.uint8)
    if video.format is PixelFormat.BGRA:
        picture = _bgra(video, pixels, room if lent else None)
        return RawVideo(picture, "bgra", video.width, video.height, sequence, captured_at)
    nv12, size = video.format is PixelFormat.NV12, video.width * video.height * 3 // 2
    if lent or video.stride != video.width or video.bottom_up or (nv12 and not pixels.flags.writeable):
        picture = room(size)
        _copy_planes(video, pixels, picture)
    else:
        picture = pixels
        if nv12:
            luma = video.width * video.height
            _split(picture[luma:].reshape(video.height // 2, video.width // 2, 2).copy(), picture[luma:])
    shape = (video.height * 3 // 2, video.width)
    return RawVideo(picture.reshape(shape), "i420", video.width, video.height, sequence, captured_at)


def _bgra(
    video: Video, pixels: NDArray[np.uint8], room: Callable[[int], NDArray[np.uint8]] | None
) -> NDArray[np.uint8]:
    """Return the picture upright, shape (height, width, 4): a view of the pixels, or a copy in `room`."""
    rows = _upright(pixels.reshape(video.height, video.stride)[:, : video.width * 4], video)
    shape = (video.height, video.width, 4)
    if room is None:
        return rows.reshape(shape)
    copy = room(rows.size).reshape(rows.shape)
    copy[:] = rows
    return copy.reshape(shape)


def _copy_planes(video: Video, pixels: NDArray[np.uint8], into: NDArray[np.uint8]) -> None:
    """Copy Y, U and V, upright and without padding, one after the other."""
    width, height, stride = video.width, video.height, video.stride
    luma, chroma = pixels[: stride * height], pixels[stride * height :]
    into[: width * height].reshape(height, width)[:] = _upright(luma.reshape(height, stride)[:, :width], video)
    colours = into[width * height :]
    if video.format is PixelFormat.NV12:
        pairs = _upright(chroma.reshape(height // 2, stride)[:, :width], video)
        _split(pairs.reshape(height // 2, width // 2, 2), colours)
    else:
        planes = colours.reshape(2, height // 2, width // 2)
        for plane, colour in zip(chroma.reshape(2, height // 2, stride // 2), planes, strict=True):
            colour[:] = _upright(plane[:, : width // 2], video)


def _split(pairs: NDArray[np.uint8], into: NDArray[np.uint8]) -> None:
    """Write U and then V of the pairs; OpenCV splits them many times faster than NumPy does."""
    cv2.split(pairs, list(into.reshape(2, *pairs.shape[:2])))


def _upright(rows: NDArray[np.uint8], video: Video) -> NDArray[np.uint8]:
    return rows[::-1] if video.bottom_up else rows
