"""The textures: a drawn face, boards and tiles. Pure."""

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

__all__ = ["boards", "face", "tiles"]

Pixels = NDArray[np.uint8]
Colour = tuple[float, float, float]

_SIDE: Final = 256


def face(skin: Colour, hair: Colour) -> Pixels:
    """Return the texture of a head as (height, width, 3), RGB, top row first: in its middle a face, around it hair.

    It is drawn as a face looks in even light from above: eyes, brows, the sides of the nose and what is under the
    lips are darker than brow, cheeks and chin. A finder of faces looks for just that.
    """
    image = np.empty((_SIDE, _SIDE, 3), np.float32)
    image[:] = np.asarray(hair) * 255
    middle = _SIDE // 2
    base = np.asarray(skin, np.float32) * 255

    def spot(x: float, y: float, wide: float, tall: float, light: float, soft: float) -> None:
        """Lighten or darken an ellipse; places and sizes in shares of the texture, from its middle."""
        mask = np.zeros((_SIDE, _SIDE), np.float32)
        at = (round(middle + x * _SIDE), round(y * _SIDE))
        cv2.ellipse(mask, at, (round(wide * _SIDE), round(tall * _SIDE)), 0, 0, 360, 1.0, -1, cv2.LINE_AA)
        mask = cv2.GaussianBlur(mask, (0, 0), soft)
        image[:] = image * (1 - mask[..., None]) + image * light * mask[..., None]

    def paint(x: float, y: float, wide: float, tall: float, colour: NDArray[np.float32], soft: float) -> None:
        mask = np.zeros((_SIDE, _SIDE), np.float32)
        at = (round(middle + x * _SIDE), round(y * _SIDE))
        cv2.ellipse(mask, at, (round(wide * _SIDE), round(tall * _SIDE)), 0, 0, 360, 1.0, -1, cv2.LINE_AA)
        mask = cv2.GaussianBlur(mask, (0, 0), soft)[..., None]
        image[:] = image * (1 - mask) + colour * mask

    paint(0, 0.6, 0.225, 0.36, base, 3)
    paint(0, 0.98, 0.6, 0.24, base * 0.86, 4)
    spot(0, 0.40, 0.13, 0.055, 1.08, 7)
    for side in (-1, 1):
        spot(side * 0.085, 0.505, 0.062, 0.038, 0.62, 4)
        spot(side * 0.105, 0.625, 0.045, 0.05, 1.1, 6)
        paint(side * 0.085, 0.462, 0.052, 0.009, np.asarray(hair, np.float32) * 200, 1.5)
        paint(side * 0.085, 0.51, 0.036, 0.016, np.asarray((235, 232, 228), np.float32), 1)
        paint(side * 0.085, 0.51, 0.016, 0.018, np.asarray((45, 32, 26), np.float32), 0.8)
        spot(side * 0.085, 0.495, 0.042, 0.008, 0.45, 1.5)
        spot(side * 0.032, 0.6, 0.012, 0.05, 0.84, 3)
        spot(side * 0.026, 0.655, 0.011, 0.008, 0.55, 1.5)
        spot(side * 0.17, 0.6, 0.03, 0.16, 0.85, 8)
    spot(0, 0.57, 0.018, 0.09, 1.12, 3)
    spot(0, 0.69, 0.05, 0.014, 0.82, 3)
    paint(0, 0.735, 0.062, 0.017, base * np.asarray((0.8, 0.5, 0.48), np.float32), 1.5)
    spot(0, 0.735, 0.058, 0.004, 0.5, 1)
    spot(0, 0.768, 0.05, 0.012, 0.8, 3)
    spot(0, 0.81, 0.05, 0.025, 1.08, 4)
    return np.clip(image, 0, 255).astype(np.uint8)


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
