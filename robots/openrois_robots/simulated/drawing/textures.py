"""The textures: a drawn face, boards and tiles. Pure."""

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["boards", "face", "tiles"]

Pixels = NDArray[np.uint8]
Floats = NDArray[np.float32]
Colour = tuple[float, float, float]

_SIDE: Final = 256
"""Pixels of each side of a texture."""
_WHITE: Final = np.asarray((235, 232, 228), np.float32)
_IRIS: Final = np.asarray((45, 32, 26), np.float32)


class _Canvas:
    """A square picture to paint on, RGB, values up to 255. Places and sizes are shares of its side.

    Args:
        colour: that fills it at first.
    """

    def __init__(self, colour: Floats) -> None:
        self.pixels: Floats = np.tile(colour, (_SIDE, _SIDE, 1)).astype(np.float32)

    def paint(self, x: float, y: float, wide: float, tall: float, colour: Floats, soft: float) -> None:
        """Paint an ellipse, `x` beside the middle and `y` below the top; `soft` is the width of its edge in pixels."""
        mask = _ellipse(x, y, wide, tall, soft)
        self.pixels = (self.pixels * (1 - mask) + colour * mask).astype(np.float32)

    def shade(self, x: float, y: float, wide: float, tall: float, light: float, soft: float) -> None:
        """Lighten (`light` above 1) or darken an ellipse."""
        self.pixels = (self.pixels * (1 + (light - 1) * _ellipse(x, y, wide, tall, soft))).astype(np.float32)


def face(skin: Colour, hair: Colour) -> Pixels:
    """Return the texture of a head as (height, width, 3), RGB, top row first: in its middle a face, around it hair.

    Eyes, brows, the sides of the nose and what is under the lips are darker than brow, cheeks and chin, as in even
    light from above: a finder of faces looks for just that.
    """
    of_skin, of_hair = (np.asarray(each, np.float32) * 255 for each in (skin, hair))
    canvas = _Canvas(of_hair)
    canvas.paint(0, 0.6, 0.225, 0.36, of_skin, 3)
    # Neck and nape.
    canvas.paint(0, 0.98, 0.6, 0.24, of_skin * 0.86, 4)
    canvas.shade(0, 0.41, 0.09, 0.05, 1.08, 7)
    for side in (-1, 1):
        canvas.shade(side * 0.067, 0.508, 0.05, 0.036, 0.58, 3.5)
        canvas.shade(side * 0.083, 0.612, 0.036, 0.044, 1.1, 5)
        canvas.paint(side * 0.067, 0.468, 0.042, 0.01, of_hair * 0.45, 1.3)
        _draw_eye(canvas, side * 0.067)
        canvas.shade(side * 0.023, 0.592, 0.009, 0.044, 0.84, 2.5)
        canvas.shade(side * 0.019, 0.64, 0.008, 0.007, 0.55, 1.3)
        canvas.shade(side * 0.125, 0.6, 0.026, 0.14, 0.85, 7)
    canvas.shade(0, 0.566, 0.013, 0.08, 1.12, 2.5)
    canvas.shade(0, 0.67, 0.035, 0.012, 0.82, 2.5)
    canvas.paint(0, 0.71, 0.05, 0.016, of_skin * np.asarray((0.8, 0.5, 0.48), np.float32), 1.3)
    canvas.shade(0, 0.71, 0.046, 0.004, 0.5, 1)
    canvas.shade(0, 0.739, 0.035, 0.011, 0.8, 2.5)
    canvas.shade(0, 0.776, 0.035, 0.022, 1.08, 3.5)
    return np.clip(canvas.pixels, 0, 255).astype(np.uint8)


def _draw_eye(canvas: _Canvas, x: float) -> None:
    canvas.paint(x, 0.512, 0.028, 0.014, _WHITE, 0.8)
    canvas.paint(x, 0.512, 0.012, 0.016, _IRIS, 0.7)
    canvas.shade(x, 0.499, 0.034, 0.008, 0.45, 1.3)


def _ellipse(x: float, y: float, wide: float, tall: float, soft: float) -> Floats:
    """Return how much of each pixel (height, width, 1) an ellipse covers."""
    mask = np.zeros((_SIDE, _SIDE), np.float32)
    middle = round(_SIDE / 2 + x * _SIDE), round(y * _SIDE)
    cv2.ellipse(mask, middle, (round(wide * _SIDE), round(tall * _SIDE)), 0, 0, 360, 1.0, -1, cv2.LINE_AA)
    return np.asarray(cv2.GaussianBlur(mask, (0, 0), soft), np.float32)[..., None]


def boards() -> Pixels:
    """Return the texture of a floor of boards, grey values around white, (height, width, 3)."""
    random = np.random.default_rng(3)
    image = np.empty((_SIDE, _SIDE), np.float32)
    for row in range(8):
        first = row * _SIDE // 8
        shade = random.uniform(0.84, 1.0, 2)
        cut = int(random.integers(40, 216))
        image[first : first + _SIDE // 8, :cut] = shade[0]
        image[first : first + _SIDE // 8, cut:] = shade[1]
        grain = cv2.resize(random.uniform(-0.05, 0.05, (16, 8)).astype(np.float32), (_SIDE, _SIDE // 8))
        image[first : first + _SIDE // 8] += grain
        image[first : first + 1] *= 0.72
        image[first : first + _SIDE // 8, cut] *= 0.75
    return _grey(image)


def tiles() -> Pixels:
    """Return the texture of a tiled floor, as `boards`."""
    random = np.random.default_rng(5)
    image = np.repeat(np.repeat(random.uniform(0.92, 1.0, (4, 4)), _SIDE // 4, axis=0), _SIDE // 4, axis=1)
    for line in range(0, _SIDE, _SIDE // 4):
        image[line : line + 2] *= 0.8
        image[:, line : line + 2] *= 0.8
    return _grey(image)


def _grey(image: NDArray[np.floating]) -> Pixels:
    return np.repeat(np.clip(image * 255, 0, 255).astype(np.uint8)[..., None], 3, axis=2)
