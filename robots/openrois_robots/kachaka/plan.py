"""The robot's map as a smaller picture, and as the outline of the floor with what stands on it."""

from dataclasses import dataclass
from math import ceil
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray
from openrois_body.messages import Floor, Point

from openrois.adapter import ComponentFailed
from openrois_robots.adapter.image_files import ImageFileError, decode_image
from openrois_robots.kachaka.layout import is_place

__all__ = ["Picture", "floor_of", "scaled"]

_MOST_PIXELS: Final = 512
"""Pixels of a side of the picture that applications get: a message of RoIS has to hold it."""
_MOST_BYTES: Final = 400_000
_COARSEST: Final = 10.0
"""Metres of a pixel."""
_FREE: Final = 200
"""Least brightness of a pixel of the floor."""
_SMALLEST: Final = 0.05
"""Square metres of an obstacle."""
_SMOOTHING: Final = 0.1
"""Metres by which an outline may be simpler than the map."""
_MOST_OBSTACLES: Final = 60
_MOST_CORNERS: Final = 900


@dataclass(frozen=True, slots=True)
class Picture:
    """A map as a picture.

    Attributes:
        png: its file.
        width: pixels.
        height: pixels.
        resolution: metres of a pixel.
    """

    png: bytes
    width: int
    height: int
    resolution: float


def scaled(data: bytes, resolution: float) -> Picture:
    """Return a map, made smaller where it is large; obstacles stay, however thin they are.

    Args:
        data: of the robot's picture.
        resolution: metres of one of its pixels.

    Raises:
        ComponentFailed: the data is no picture, or has no scale.
    """
    pixels = _decoded(data, resolution)
    factor = max(1, ceil(max(pixels.shape) / _MOST_PIXELS))
    while True:
        smaller = _smaller(pixels, factor)
        _, png = cv2.imencode(".png", smaller, (cv2.IMWRITE_PNG_COMPRESSION, 9))
        height, width = smaller.shape
        if len(png) <= _MOST_BYTES or max(width, height) < 32:
            return Picture(png.tobytes(), width, height, resolution * factor)
        factor += 1


def floor_of(data: bytes, resolution: float, origin: Point) -> Floor | None:
    """Return the floor of a map: its largest free area, and what stands in it; None where nothing is free.

    Args:
        data: of the robot's picture.
        resolution: metres of one of its pixels.
        origin: of its corner at the bottom on the left, in metres.

    Raises:
        ComponentFailed: the data is no picture, has no scale, or lies nowhere.
    """
    pixels = _decoded(data, resolution)
    if not is_place(*origin):
        raise ComponentFailed(f"the robot's map lies nowhere: its corner is at {origin[0]:g},{origin[1]:g}")
    free = (pixels >= _FREE).astype(np.uint8)
    contours, hierarchy = cv2.findContours(free, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    outer = [index for index in range(len(contours)) if hierarchy[0][index][3] < 0]
    if not outer:
        return None
    largest = max(outer, key=lambda index: cv2.contourArea(contours[index]))

    def corners(index: int) -> tuple[Point, ...]:
        simple = cv2.approxPolyDP(contours[index], _SMOOTHING / resolution, True)[:, 0, :]
        height = pixels.shape[0]
        return tuple(
            (origin[0] + float(column) * resolution, origin[1] + float(height - row) * resolution)
            for column, row in simple
        )

    outline = corners(largest)
    if len(outline) < 3:
        return None
    least = _SMALLEST / resolution**2
    holes = [index for index in range(len(contours)) if hierarchy[0][index][3] == largest]
    holes = [index for index in holes if cv2.contourArea(contours[index]) >= least]
    holes.sort(key=lambda index: -cv2.contourArea(contours[index]))
    obstacles: list[tuple[Point, ...]] = []
    left = _MOST_CORNERS - len(outline)
    for index in holes[:_MOST_OBSTACLES]:
        polygon = corners(index)
        if 3 <= len(polygon) <= left:
            obstacles.append(polygon)
            left -= len(polygon)
    return Floor(outline[:_MOST_CORNERS], tuple(obstacles))


def _decoded(data: bytes, resolution: float) -> NDArray[np.uint8]:
    if not 0 < resolution <= _COARSEST:
        raise ComponentFailed(f"the robot's map has no scale: a pixel of it is {resolution:g} m")
    try:
        return decode_image(data, is_grey=True)
    except ImageFileError as error:
        raise ComponentFailed(f"the robot's map is no picture that can be read: {error}") from None


def _smaller(pixels: NDArray[np.uint8], factor: int) -> NDArray[np.uint8]:
    """Return each square of pixels as its darkest one."""
    if factor == 1:
        return pixels
    rows, columns = (ceil(side / factor) for side in pixels.shape)
    padded = np.full((rows * factor, columns * factor), 255, np.uint8)
    # What is added is at the top and on the right: the origin stays where it is.
    padded[rows * factor - pixels.shape[0] :, : pixels.shape[1]] = pixels
    darkest: NDArray[np.uint8] = padded.reshape(rows, factor, columns, factor).min(axis=(1, 3))
    return darkest
