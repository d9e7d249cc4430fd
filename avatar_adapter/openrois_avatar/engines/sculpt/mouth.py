"""The mouth: lips that deform, teeth, tongue and the dark behind them.

The lips are a grid (rings, spokes, 3) around the line where they meet; spokes run from the avatar's left corner over
the upper lip to the right corner and back along the lower lip. Rings run from inside the mouth to the cheek.
"""

import numpy as np

from openrois_avatar.engines.animation.pose import Mouth
from openrois_avatar.engines.sculpt.distance import Array
from openrois_avatar.engines.sculpt.head import MOUTH, MOUTH_PATCH, DepthMap, jaw_share, jaw_turned, smooth

SPOKES = 60
TONGUE_LIFT = (0.0, -0.17, 0.090)
"""Where the tongue goes (dm) when it is raised fully."""
TEETH_HIDE = (0.0, 0.10, 0.030)
"""Where the upper teeth go (dm), seen from the lips, when these are rounded fully."""
JAW_ANGLE = 0.23
"""Radians at a fully open jaw."""
_HALF_WIDTH = 0.235
INSIDE = 3
"""How many rings lie behind the lips."""
_LIP = np.asarray([0.0, 0.12, 0.3, 0.52, 0.76, 1.0, 1.12])
_SKIN = np.asarray([0.12, 0.26, 0.42, 0.6, 0.8, 1.0])
BORDER = INSIDE + 5
"""The ring where the red of the lips ends."""
RINGS = INSIDE + len(_LIP) + len(_SKIN)

_ANGLE = np.arange(SPOKES) * 2 * np.pi / SPOKES
_ACROSS, _HEIGHT = np.cos(_ANGLE), np.sin(_ANGLE)
_UPPER = _HEIGHT > 1e-6
_MIDDLE = np.clip(1 - _ACROSS**2, 0, 1)


_TEETH = np.linspace(-1, 1, 17)
_TOOTH = ((0.0, 0.03), (0.35, 0.0), (0.85, 0.0), (1.0, 0.02))
"""From root to edge: how far along, and how far back in dm."""


class Lips:
    """The lips and the skin around them, deformed by a mouth shape."""

    def __init__(self, depth: DepthMap) -> None:
        self._depth = depth
        rest_x, rest_z = self._flat()
        surface = np.stack([rest_x, depth(rest_x, MOUTH[2] + rest_z), MOUTH[2] + rest_z], axis=2)
        self.skin_normals = depth.normals(surface[..., 0], surface[..., 2])
        """Normals of the face under every vertex at rest, (RINGS, SPOKES, 3)."""
        self._rest = self._with_relief(surface)
        ring = np.arange(RINGS)
        # Beside the corners the skin folds when they rise: it is lit as the face is, or it shows dark patches.
        self.smoothed = smooth((ring - BORDER) / 2)[:, None] * smooth((np.abs(_ACROSS) - 0.45) / 0.35)
        """How far the skin around the lips is lit as the face under it, (RINGS, SPOKES) 0..1."""
        self._near_lip = (1 - smooth((ring - BORDER - 1) / (RINGS - BORDER - 2)))[:, None]
        where = jaw_share(surface)
        at_lip = np.where(_UPPER, 0.38 * (1 - _MIDDLE**0.35), 0.38 + 0.62 * _MIDDLE**0.35)
        self._jaw = where + (at_lip - where) * self._near_lip
        self._red = np.clip(1 - np.abs(ring - INSIDE - 2.0) / 4.0, 0, 1)[:, None]

    def _flat(self) -> tuple[Array, Array]:
        """The x and z (from the mouth's centre) of every vertex at rest."""
        line_x = _HALF_WIDTH * _ACROSS
        line_z = 0.030 * _ACROSS**2 - 0.010 * np.exp(-((_ACROSS / 0.22) ** 2))
        bow = 1 - 0.20 * np.exp(-((_ACROSS / 0.12) ** 2)) + 0.10 * np.exp(-(((np.abs(_ACROSS) - 0.30) / 0.16) ** 2))
        height = np.where(_UPPER, 0.070 * _MIDDLE**0.75 * bow, -0.092 * _MIDDLE**0.85)
        rows_x = [line_x * 0.97] * INSIDE
        rows_z = [line_z] * INSIDE
        for share in _LIP:
            rows_x.append(line_x * (1 + 0.05 * share))
            rows_z.append(line_z + height * share)
        edge_x, edge_z = rows_x[-1], rows_z[-1]
        for share in _SKIN:
            rows_x.append(edge_x + (MOUTH_PATCH[0] * _ACROSS - edge_x) * share)
            rows_z.append(edge_z + (np.where(_UPPER, MOUTH_PATCH[1], MOUTH_PATCH[2]) * _HEIGHT - edge_z) * share)
        return np.stack(rows_x), np.stack(rows_z)

    def _with_relief(self, surface: Array) -> Array:
        fullness = np.where(_UPPER, 0.050, 0.062) * _MIDDLE**0.5
        relief = np.zeros((RINGS, SPOKES))
        relief[INSIDE : INSIDE + len(_LIP)] = np.outer([0.25, 0.62, 0.95, 0.98, 0.66, 0.22, 0.04], fullness)
        for ring, depth in enumerate((0.20, 0.12, 0.05)):
            relief[ring] = -depth
        # The lips sit in a shallow hollow, deepest at the corners.
        relief[INSIDE : INSIDE + len(_LIP)] -= 0.028 * (1 - _MIDDLE) ** 1.5
        rest = surface.copy()
        rest[:, :, 1] -= relief
        return rest

    def grid(self, mouth: Mouth) -> Array:
        """Vertices (RINGS, SPOKES, 3) in head space."""
        near, grid = self._near_lip, self._rest.copy()
        x, y, z = grid[:, :, 0], grid[:, :, 1], grid[:, :, 2]
        narrow = 1 - 0.42 * mouth.round * near
        spread = (0.085 * mouth.wide + 0.045 * mouth.smile) * near
        corner = np.abs(_ACROSS) ** 1.5
        away = np.where(_UPPER, 1.0, -1.0)
        # A narrow mouth opens evenly, a wide one most in the middle.
        arch = _MIDDLE ** (0.6 - 0.25 * mouth.round)
        z += near * (
            np.where(_UPPER, mouth.upper * 0.055, -mouth.lower * 0.060) * arch + mouth.smile * 0.062 * corner**2
        )
        # Lips that push forward turn their red outwards, at the corners too; pressed lips roll it inwards.
        rolled = mouth.round * (0.034 - 0.020 * arch) - mouth.press * 0.034 * arch - mouth.wide * 0.010 * arch
        z += away * self._red * rolled
        y += near * (-0.105 * mouth.round * (0.4 + 0.6 * arch) + 0.05 * (mouth.wide + mouth.smile) * corner)
        y += self._red * arch * 0.045 * mouth.press
        x += np.sign(_ACROSS) * corner * 0.03 * mouth.press * near
        tuck = mouth.bite * arch * np.where(_UPPER, 0.0, 1.0)
        z += self._red * tuck * 0.060
        y += self._red * tuck * 0.070
        x[...] = x * narrow + np.sign(_ACROSS) * corner * spread
        return jaw_turned(grid, self._jaw, JAW_ANGLE * mouth.jaw)


def teeth(upper: bool) -> Array:
    """A row of teeth as a curved strip (4, n, 3), in head space at rest."""
    x = 0.232 * _TEETH
    y = MOUTH[1] + 0.075 + 0.17 * _TEETH**2
    rise = 0.030 * np.abs(_TEETH) ** 3
    top, bottom = (0.075 + 0 * rise, -0.032 + rise) if upper else (-0.050 + rise, -0.125 + rise)
    rows = []
    for share, bulge in _TOOTH:
        rows.append(np.stack([x, y + bulge, MOUTH[2] + top + (bottom - top) * share], axis=1))
    return np.stack(rows)


def teeth_openness(front: float) -> Array:
    """How open the vertices of a row of teeth are, (n,): `front` in the middle, hardly at the sides."""
    return np.tile(front * (1 - 0.9 * np.abs(_TEETH) ** 3), len(_TOOTH))


def tongue() -> Array:
    """The tongue as a low dome (7, 11, 3), in head space at rest, its tip forward."""
    along, across = np.linspace(0, 1, 7)[:, None], np.linspace(-1, 1, 11)[None, :]
    width = 0.165 * np.sqrt(np.clip(1 - (1 - along) ** 2.6, 0.0, 1.0)) + 0.01
    x = width * across
    y = MOUTH[1] + 0.09 + 0.34 * along + 0 * across
    z = MOUTH[2] - 0.128 + 0.080 * np.sin(np.pi * (0.18 + 0.6 * along)) * (1 - 0.55 * across**2)
    return np.stack([x + 0 * along, y, z], axis=2)


def cavity(rim: Array) -> Array:
    """The dark bowl behind the lips (5, n, 3): it begins where their innermost ring, (n, 3), ends."""
    middle = rim.mean(axis=0)
    rows = []
    for size, depth in ((1.0, 0.0), (1.06, 0.08), (1.05, 0.18), (0.7, 0.27), (0.01, 0.30)):
        rows.append(middle + (rim - middle) * size + np.asarray((0.0, depth, 0.0)))
    return np.stack(rows)
