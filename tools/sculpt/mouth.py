"""The mouth at rest: lips and the skin around them, teeth and tongue.

The lips are a grid (rings, spokes, 3) around the line where they meet; spokes run from the avatar's left corner over
the upper lip to the right corner and back along the lower lip. Rings run from inside the mouth to the cheek.
"""

import numpy as np
from openrois_avatar.engines.figure.head import MOUTH, DepthMap
from openrois_avatar.engines.figure.mesh import Array
from openrois_avatar.engines.figure.mouth import ACROSS, HEIGHT, INSIDE, MIDDLE, NEAR_LIP, RINGS, SPOKES, UPPER

from tools.sculpt.head import MOUTH_PATCH, jaw_share, normals_of_face

_HALF_WIDTH = 0.235
_LIP = np.asarray([0.0, 0.12, 0.3, 0.52, 0.76, 1.0, 1.12])
_SKIN = np.asarray([0.12, 0.26, 0.42, 0.6, 0.8, 1.0])
_TEETH = np.linspace(-1, 1, 17)
_TOOTH = ((0.0, 0.03), (0.35, 0.0), (0.85, 0.0), (1.0, 0.02))
"""From root to edge: how far along, and how far back in dm."""


class LipsAtRest:
    """The data of the mouth that `Lips` and their motion need."""

    def __init__(self, depth: DepthMap) -> None:
        x, z = _flat()
        surface = np.stack([x, depth(x, MOUTH[2] + z), MOUTH[2] + z], axis=2)
        self.skin_normals = normals_of_face(depth, surface[..., 0], surface[..., 2])
        """Normals of the face under every vertex, (RINGS, SPOKES, 3)."""
        self.rest = _with_relief(surface)
        """The vertices, (RINGS, SPOKES, 3)."""
        where = jaw_share(surface)
        at_lip = np.where(UPPER, 0.38 * (1 - MIDDLE**0.35), 0.38 + 0.62 * MIDDLE**0.35)
        self.jaw = where + (at_lip - where) * NEAR_LIP
        """How far each vertex follows the jaw, (RINGS, SPOKES)."""


def _flat() -> tuple[Array, Array]:
    """The x and z (from the mouth's centre) of every vertex at rest."""
    line_x = _HALF_WIDTH * ACROSS
    line_z = 0.030 * ACROSS**2 - 0.010 * np.exp(-((ACROSS / 0.22) ** 2))
    bow = 1 - 0.20 * np.exp(-((ACROSS / 0.12) ** 2)) + 0.10 * np.exp(-(((np.abs(ACROSS) - 0.30) / 0.16) ** 2))
    height = np.where(UPPER, 0.070 * MIDDLE**0.75 * bow, -0.092 * MIDDLE**0.85)
    rows_x = [line_x * 0.97] * INSIDE
    rows_z = [line_z] * INSIDE
    for share in _LIP:
        rows_x.append(line_x * (1 + 0.05 * share))
        rows_z.append(line_z + height * share)
    edge_x, edge_z = rows_x[-1], rows_z[-1]
    for share in _SKIN:
        rows_x.append(edge_x + (MOUTH_PATCH[0] * ACROSS - edge_x) * share)
        rows_z.append(edge_z + (np.where(UPPER, MOUTH_PATCH[1], MOUTH_PATCH[2]) * HEIGHT - edge_z) * share)
    return np.stack(rows_x), np.stack(rows_z)


def _with_relief(surface: Array) -> Array:
    fullness = np.where(UPPER, 0.050, 0.062) * MIDDLE**0.5
    relief = np.zeros((RINGS, SPOKES))
    relief[INSIDE : INSIDE + len(_LIP)] = np.outer([0.25, 0.62, 0.95, 0.98, 0.66, 0.22, 0.04], fullness)
    for ring, depth in enumerate((0.20, 0.12, 0.05)):
        relief[ring] = -depth
    # The lips sit in a shallow hollow, deepest at the corners.
    relief[INSIDE : INSIDE + len(_LIP)] -= 0.028 * (1 - MIDDLE) ** 1.5
    rest = surface.copy()
    rest[:, :, 1] -= relief
    return rest


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
    """Return the openness of the vertices of a row of teeth, (n,): `front` in the middle, hardly any at the sides."""
    return np.tile(front * (1 - 0.9 * np.abs(_TEETH) ** 3), len(_TOOTH))


def tongue() -> Array:
    """The tongue as a low dome (7, 11, 3), in head space at rest, its tip forward."""
    along, across = np.linspace(0, 1, 7)[:, None], np.linspace(-1, 1, 11)[None, :]
    width = 0.165 * np.sqrt(np.clip(1 - (1 - along) ** 2.6, 0.0, 1.0)) + 0.01
    x = width * across
    y = MOUTH[1] + 0.09 + 0.34 * along + 0 * across
    z = MOUTH[2] - 0.128 + 0.080 * np.sin(np.pi * (0.18 + 0.6 * along)) * (1 - 0.55 * across**2)
    return np.stack([x + 0 * along, y, z], axis=2)
