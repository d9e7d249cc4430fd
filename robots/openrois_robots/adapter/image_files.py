"""JPEG and PNG files of robots as pixels. Pure.

The size is read before anything is decoded: a file of 300 bytes may say that it has a thousand million pixels.
"""

import struct
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["MOST_PIXELS", "ImageFileError", "decode_image", "image_size"]

MOST_PIXELS: Final = 8192 * 8192
"""Pixels of a picture."""

_PNG: Final = b"\x89PNG\r\n\x1a\n"
_JPEG: Final = b"\xff\xd8"
_FRAMES: Final = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers of JPEG that begin a frame, which has the size."""
_BARE: Final = frozenset({0x01, *range(0xD0, 0xD9)})
"""Markers without a length."""


class ImageFileError(ValueError):
    """Data that is no picture which is read here; the sentence says why."""


def decode_image(data: bytes, *, is_grey: bool = False) -> NDArray[np.uint8]:
    """Return the pixels of a JPEG or PNG: bgr24 of shape (height, width, 3), or (height, width) where `is_grey`.

    Raises:
        ImageFileError: it is none, is larger than `MOST_PIXELS`, or cannot be decoded.
    """
    width, height = image_size(data)
    if not 0 < width * height <= MOST_PIXELS:
        raise ImageFileError(f"a picture of {width}x{height} is not read: it may have {MOST_PIXELS} pixels")
    try:
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_GRAYSCALE if is_grey else cv2.IMREAD_COLOR)
    except cv2.error:
        pixels = None
    if pixels is None:
        raise ImageFileError(f"a picture of {width}x{height} with {len(data)} bytes cannot be decoded")
    return np.asarray(pixels, np.uint8)


def image_size(data: bytes) -> tuple[int, int]:
    """Return the width and height that a JPEG or PNG says it has.

    Raises:
        ImageFileError: it says none, or is neither.
    """
    try:
        if data.startswith(_PNG):
            width, height = struct.unpack_from(">II", data, 16)
            return width, height
        if data.startswith(_JPEG):
            return _jpeg_size(data)
    except (struct.error, IndexError):
        raise ImageFileError(f"a picture with {len(data)} bytes ends before its size") from None
    raise ImageFileError(f"{len(data)} bytes are neither a JPEG nor a PNG")


def _jpeg_size(data: bytes) -> tuple[int, int]:
    at = len(_JPEG)
    while True:
        if data[at] != 0xFF:
            raise ImageFileError(f"a JPEG with {len(data)} bytes has no size")
        marker, at = data[at + 1], at + 1
        if marker == 0xFF:
            continue
        at += 1
        if marker in _FRAMES:
            height, width = struct.unpack_from(">HH", data, at + 3)
            return width, height
        if marker not in _BARE:
            at += max(2, struct.unpack_from(">H", data, at)[0])
