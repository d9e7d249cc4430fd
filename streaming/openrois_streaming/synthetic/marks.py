"""Marks at each whole second of wall time: a lamp in the picture and a burst in the sound."""

import numpy as np
from numpy.typing import NDArray

from openrois_streaming.source.stamp import stamp_rows

MARKER_HZ = 1000
MARKER_SECONDS = 0.05
"""The tone's marker starts at each whole second of wall time, at phase 0; the lamp shines as long."""

BLACK, WHITE, GREY = 16, 235, 128

_MARGIN = 8


def shines(wall: float, fps: float) -> bool:
    """Tell whether the lamp shines in a picture of `wall` (epoch seconds), of a source of `fps` pictures a second."""
    return wall % 1 < max(MARKER_SECONDS, 1 / fps)


def draw_lamp(picture: NDArray[np.uint8], shining: bool) -> None:
    """Draw the lamp into an I420 picture: a white or black square at the lower right, above the stamp."""
    height, width = picture.shape[0] * 2 // 3, picture.shape[1]
    size = height // 20 * 2
    bottom = (height - stamp_rows(height)) // 2 * 2 - 4
    right = width - _MARGIN
    picture[bottom - size : bottom, right - size : right] = WHITE if shining else BLACK
    planes = colour_planes(picture, height)
    planes[:, (bottom - size) // 2 : bottom // 2, (right - size) // 2 : right // 2] = GREY


def colour_planes(picture: NDArray[np.uint8], height: int) -> NDArray[np.uint8]:
    """Return U and V of an I420 picture as views of shape (2, height / 2, width / 2)."""
    width = picture.shape[1]
    return picture.reshape(-1)[width * height :].reshape(2, height // 2, width // 2)
