"""A JPEG and a PNG, and files that say that they have another size."""

import struct

import cv2
import numpy as np

__all__ = ["JPEG", "PNG", "RED", "resized"]

RED = (20, 30, 200)
"""Blue, green and red."""


def _encoded(extension: str, width: int = 64, height: int = 48) -> bytes:
    return bytes(cv2.imencode(extension, np.full((height, width, 3), RED, np.uint8))[1].tobytes())


def resized(data: bytes, width: int, height: int) -> bytes:
    """Return a file that says that it has another size."""
    if data.startswith(b"\x89PNG"):
        return data[:16] + struct.pack(">II", width, height) + data[24:]
    at = data.index(b"\xff\xc0") + 5
    return data[:at] + struct.pack(">HH", height, width) + data[at + 4 :]


JPEG, PNG = _encoded(".jpg"), _encoded(".png")
"""64 pixels wide, 48 high."""
