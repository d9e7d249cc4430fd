"""The pictures of the simulated robot's camera: a floor that moves with it, and a number for each picture."""

from math import cos, sin
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["SIZE", "draw", "jpeg"]

SIZE: Final = 320, 240
"""Width and height, in pixels."""
_PIXELS: Final = 60.0
"""Pixels of a metre."""


def draw(x: float, y: float, th: float, number: int) -> NDArray[np.uint8]:
    """Return the picture from above at a place, as bgr24."""
    width, height = SIZE
    rows, columns = np.indices((height, width))
    across, ahead = (columns - width / 2) / _PIXELS, (height / 2 - rows) / _PIXELS
    east = x + ahead * cos(th) + across * sin(th)
    north = y + ahead * sin(th) - across * cos(th)
    tiles = (np.floor(east).astype(int) + np.floor(north).astype(int)) % 2
    colours = np.array([(120, 130, 140), (160, 170, 180)], np.uint8)
    picture = np.ascontiguousarray(colours[tiles])
    where: Any = (8, height - 10)
    cv2.putText(picture, str(number), where, cv2.FONT_HERSHEY_SIMPLEX, 0.6, (30, 30, 200), 2)
    return picture


def jpeg(picture: NDArray[np.uint8]) -> bytes:
    """Return a picture as JPEG."""
    is_done, data = cv2.imencode(".jpg", picture)
    assert is_done
    return data.tobytes()
