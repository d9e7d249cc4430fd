"""The parts of the figure that are seen from farther away: hips, legs, shoes, and the back of the jumper."""

import numpy as np
from openrois_avatar.engines import palette
from openrois_avatar.engines.figure.baked import Piece
from openrois_avatar.engines.figure.mesh import Array, Mesh
from openrois_avatar.engines.figure.rig import ANKLE, HIP, KNEE

from tools.sculpt.body import jumper_field
from tools.sculpt.distance import Field, Triple, cone, ellipsoid, join, mirrored
from tools.sculpt.mesh import compact, polygonised
from tools.sculpt.pieces import plain, still

_CELL = 0.17
_WAIST, _HEM = -3.1, -5.0
"""Where in front the lower part of the jumper begins, over the upper one, and where it ends, in dm."""


def whole_jumper_field(points: Array) -> Array:
    """The jumper down to its hem."""
    return join(jumper_field(points), ellipsoid(points, (0.0, 0.33, -4.35), (0.98, 0.62, 1.05)), 0.35)


def thigh_field(points: Array) -> Array:
    """The left thigh, in its trouser leg."""
    return cone(points, HIP, KNEE, 0.46, 0.34)


def shin_field(points: Array) -> Array:
    """The left shin, in its trouser leg."""
    return cone(points, KNEE, ANKLE, 0.345, 0.27)


def shoe_field(points: Array) -> Array:
    """The left shoe: flat below."""
    shoe = join(
        ellipsoid(points, (0.50, 0.02, -10.84), (0.30, 0.52, 0.24)),
        ellipsoid(points, (0.50, 0.45, -10.74), (0.27, 0.32, 0.30)),
        0.15,
    )
    return np.maximum(shoe, -11.0 - points[:, 2])


def hips_field(points: Array) -> Array:
    """Return the distance to the hips: the trousers between jumper and thighs."""
    p = mirrored(points)
    return join(ellipsoid(p, (0.0, 0.36, -4.95), (0.90, 0.58, 0.55)), ellipsoid(p, HIP, (0.47, 0.47, 0.47)), 0.2)


def meshes(trousers: str = palette.TROUSERS, shoes: str = palette.SHOES) -> dict[str, Mesh]:
    """Hips and the left leg by name, in body space, in these colours."""
    return {
        "hips": sculpted(hips_field, (-1.1, -0.5, -5.8), (1.1, 1.1, -4.3), _CELL, trousers),
        "thigh": sculpted(thigh_field, (-0.2, -0.3, -8.4), (1.2, 1.1, -4.5), _CELL, trousers),
        "shin": sculpted(shin_field, (-0.1, -0.2, -11.0), (1.1, 0.9, -7.3), _CELL, trousers),
        "foot": sculpted(shoe_field, (0.0, -0.7, -11.2), (1.0, 1.0, -10.3), 0.12, shoes),
    }


def sculpted(field: Field, low: Triple, high: Triple, cell: float, colour: str) -> Mesh:
    """A field's surface inside a box, in one colour."""
    points, normals, faces = polygonised(field, low, high, cell)
    count = len(points)
    return Mesh(points, normals, faces, plain(colour, count), np.ones(count))


def pieces() -> list[Piece]:
    """Everything, for the spaces that `rig.leg_frames` places."""
    made = [still("jumper_back", "back", "cloth", _back())]
    shapes = meshes()
    made.append(still("hips", "hips", "cloth", shapes.pop("hips")))
    for name, mesh in shapes.items():
        made += [still(name, f"{name}_{end}", "cloth", mesh, side=side) for end, side in (("left", 1), ("right", -1))]
    return made


def _back() -> Mesh:
    """The part of the jumper that the close view leaves out."""
    mesh = sculpted(whole_jumper_field, (-1.65, -0.75, -5.6), (1.65, 1.25, -1.2), 0.14, palette.JUMPER)
    points = mesh.vertices
    hidden = (points[:, 2] < _HEM) | ((points[:, 1] < 0.68) & (points[:, 2] > _WAIST))
    faces = mesh.faces[~hidden[mesh.faces].any(axis=1)]
    # It lies under the collar.
    points = points - mesh.normals * (0.07 * (points[:, 2:] > -2.0))
    return compact(Mesh(points, mesh.normals, faces, mesh.albedo, mesh.openness))
