"""The visitor as meshes: a simpler figure than the avatar, who is seen from farther away."""

from typing import Final

import numpy as np
from openrois_avatar.engines import palette
from openrois_avatar.engines.figure.baked import Piece
from openrois_avatar.engines.figure.mesh import Array, Mesh
from openrois_avatar.engines.figure.rig import SHOULDER

from tools.sculpt import legs
from tools.sculpt.distance import Triple, cone, ellipsoid, join, mirrored
from tools.sculpt.hair import cap_field
from tools.sculpt.legs import sculpted
from tools.sculpt.mesh import merged
from tools.sculpt.pieces import still

_WRIST: Final = (1.34, 0.16, -4.30)
_WAIST: Final = ((0.0, 0.33, -4.35), (0.98, 0.62, 1.05))


def pieces() -> list[Piece]:
    """Every limb in its own space, which is body space while the visitor stands."""
    lower = legs.meshes(palette.VISITOR_TROUSERS, palette.WOOD_DARK)
    trunk = sculpted(_trunk_field, (-1.6, -0.8, -5.5), (1.6, 1.3, -1.1), 0.20, palette.VISITOR_JACKET)
    whole = {"trunk": trunk, "head": _head(), "hips": lower.pop("hips")}
    twofold = {"arm": merged([_sleeve(), _hand()]), **lower}
    return [
        *(still(name, name, "cloth", mesh) for name, mesh in whole.items()),
        *(
            still(name, f"{name}_{end}", "cloth", mesh, side=side)
            for name, mesh in twofold.items()
            for end, side in (("left", 1), ("right", -1))
        ),
    ]


def _trunk_field(points: Array) -> Array:
    """A jacket from the neck to its hem."""
    p = mirrored(points)
    trunk = join(ellipsoid(p, (0.0, 0.32, -3.00), (1.02, 0.58, 1.45)), ellipsoid(p, *_WAIST), 0.35)
    trunk = join(trunk, cone(p, (0.20, 0.30, -1.80), (1.02, 0.31, -1.90), 0.34, 0.30), 0.45)
    trunk = join(trunk, cone(p, (0.10, 0.34, -1.30), (0.84, 0.36, -1.72), 0.30, 0.24), 0.35)
    return np.maximum(trunk - 0.05, -5.05 - points[:, 2])


def _sleeve() -> Mesh:
    return sculpted(
        lambda points: cone(points, SHOULDER, _WRIST, 0.33, 0.22),
        (0.6, -0.3, -4.8), (1.8, 0.8, -1.4), 0.2, palette.VISITOR_JACKET,
    )  # fmt: skip


def _hand() -> Mesh:
    return sculpted(
        lambda points: ellipsoid(points, (1.36, 0.10, -4.75), (0.16, 0.22, 0.42)),
        (1.0, -0.3, -5.4), (1.7, 0.5, -4.2), 0.15, palette.VISITOR_SKIN,
    )  # fmt: skip


def _head() -> Mesh:
    def skull(points: Array) -> Array:
        head = join(
            ellipsoid(points, (0.0, 0.08, 0.12), (0.80, 0.88, 1.0)),
            ellipsoid(points, (0.0, -0.10, -0.52), (0.56, 0.60, 0.50)),
            0.3,
        )
        nose = cone(points, (0.0, -0.78, 0.02), (0.0, -0.92, -0.28), 0.07, 0.10)
        return join(join(head, nose, 0.1), cone(points, (0, 0.15, -0.5), (0, 0.28, -1.8), 0.36, 0.38), 0.2)

    skin = sculpted(skull, (-1.0, -1.2, -1.9), (1.0, 1.2, 1.3), 0.16, palette.VISITOR_SKIN)
    hair = sculpted(cap_field, (-1.1, -1.0, -1.1), (1.1, 1.3, 1.5), 0.18, palette.VISITOR_HAIR)
    eyes = [_spot((x, -0.70, 0.06), (0.10, 0.12, 0.10), palette.LASH) for x in (-0.32, 0.32)]
    return merged([skin, hair, *eyes, _spot((0.0, -0.66, -0.52), (0.20, 0.06, 0.05), palette.LID_SHADE)])


def _spot(centre: Triple, radii: Triple, colour: str) -> Mesh:
    def ball(points: Array) -> Array:
        return ellipsoid(points, centre, radii)

    reach = np.asarray(radii) + 0.08
    return sculpted(ball, np.asarray(centre) - reach, np.asarray(centre) + reach, 0.05, colour)
