"""A picture of the camera for the analysis: small and grey, and with a face set upright."""

import math
from functools import cached_property
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from openrois_streaming.source.source import RawVideo

from openrois_body.vision.box import Face

__all__ = ["View", "upright"]

_SIDE: Final = 288
"""Pixels of the grey picture's shorter side at most: a face of a twelfth of it is still found."""


class View:
    """One picture.

    Args:
        raw: the camera's picture, for a backend that needs colours or all pixels.
    """

    def __init__(self, raw: RawVideo) -> None:
        self.raw = raw

    @property
    def moment(self) -> float:
        """The capture time, in seconds of the media clock."""
        return self.raw.captured_at

    @property
    def aspect(self) -> float:
        """The ratio of width to height."""
        return self.raw.width / self.raw.height

    @cached_property
    def grey(self) -> NDArray[np.uint8]:
        """The luma of the pixels (height, width), scaled down where the picture is large."""
        raw = self.raw
        scale = min(1.0, _SIDE / min(raw.width, raw.height))
        size = max(2, round(raw.width * scale)), max(2, round(raw.height * scale))
        planes = raw.data[: raw.height] if raw.format == "i420" else raw.data
        small = np.ascontiguousarray(planes) if scale == 1.0 else cv2.resize(planes, size, interpolation=cv2.INTER_AREA)
        if raw.format == "bgra":
            small = cv2.cvtColor(small, cv2.COLOR_BGRA2GRAY)
        elif raw.format == "bgr24":
            small = cv2.cvtColor(small, cv2.COLOR_BGR2GRAY)
        return np.asarray(small, np.uint8)


def upright(
    grey: NDArray[np.uint8], face: Face, scale: float, side: int
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Return a square of a picture with a face upright in its middle, and the affine matrix (2, 3) of that.

    Args:
        grey: the picture (height, width).
        face: in the middle.
        scale: how much larger the square shows it.
        side: of the square, in pixels.
    """
    height, width = grey.shape
    x, y = face.box.centre[0] * width, face.box.centre[1] * height
    matrix = np.asarray(cv2.getRotationMatrix2D((x, y), math.degrees(face.roll), scale), np.float64)
    matrix[:, 2] += (side / 2 - x, side / 2 - y)
    square = cv2.warpAffine(grey, matrix, (side, side), borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(square, np.uint8), matrix
