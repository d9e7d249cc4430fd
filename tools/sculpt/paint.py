"""Colour on the clay: where skin is redder, where hair throws its shadow."""

import numpy as np
from openrois_avatar.engines import palette
from openrois_avatar.engines.figure.mesh import Array
from openrois_avatar.engines.figure.shading import linear

_TO_LIGHT = np.asarray((-0.25, -0.45, 0.86))


class Shadow:
    """The shadow of a cloud of balls (the hair), falling along the key light and softly around each ball."""

    def __init__(self, centres: Array, radius: float) -> None:
        self._centres, self._radius = centres.astype(np.float32), radius

    def __call__(self, points: Array) -> Array:
        """Openness (n,) of the points: 1 in the light, less under the hair."""
        offset = self._centres[None] - points.astype(np.float32)[:, None]
        along = offset @ _TO_LIGHT.astype(np.float32)
        aside = np.sqrt(np.maximum(np.einsum("ijk,ijk->ij", offset, offset) - along * along, 0))
        covered = (
            np.clip(1.6 - aside / self._radius, 0, 1)
            * np.clip(along / 0.08 + 0.4, 0, 1)
            * np.clip(1.15 - along / 0.45, 0, 1)
        )
        return np.asarray(1 - 0.55 * covered.max(axis=1), float)


def skin(points: Array) -> Array:
    """Albedo (n, 3) of the face: blush on cheeks, nose and chin."""
    x, y, z = np.abs(points[:, 0]), points[:, 1], points[:, 2]
    front = np.clip(-y * 2 - 0.2, 0, 1)
    cheek = np.exp(-(((x - 0.47) / 0.20) ** 2) - ((z + 0.345) / 0.14) ** 2)
    nose = np.exp(-((x / 0.10) ** 2) - ((z + 0.345) / 0.09) ** 2) * np.clip((-y - 0.82) * 8, 0, 1)
    chin = np.exp(-((x / 0.16) ** 2) - ((z + 0.86) / 0.10) ** 2)
    return _blushed((0.50 * cheek + 0.35 * nose + 0.15 * chin) * front)


def veil(openness: Array) -> Array:
    """Openness as skin shows it: light inside the skin fills its folds."""
    return np.asarray(1 - 0.6 * (1 - openness))


def ear(points: Array, openness: Array) -> Array:
    """Albedo (n, 3) of an ear: redder where it is hollow."""
    return _blushed(0.25 + 0.5 * (1 - openness) + 0 * points[:, 0])


def neck(points: Array) -> Array:
    """Albedo (n, 3) of neck and throat."""
    return _blushed(np.full(len(points), 0.08))


def hand(points: Array) -> Array:
    """Albedo (n, 3) of a hand in its own frame: redder at palm and finger tips."""
    tips = np.clip((points[:, 2] - 0.95) / 0.3, 0, 1) * 0.25
    palm = np.exp(-(((points[:, 1] + 0.12) / 0.06) ** 2)) * 0.15
    return _blushed(tips + palm + 0.06)


def _blushed(amount: Array) -> Array:
    share = np.clip(amount, 0, 1)[:, None]
    return np.asarray(linear(palette.SKIN) * (1 - share) + linear(palette.BLUSH) * share, float)
