"""A part of the figure: a mesh that follows the pose, and how its colours are made."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure.mesh import Array, Faces
from openrois_avatar.engines.figure.rig import Space
from openrois_avatar.engines.figure.shading import Surface

State = tuple[float, ...]
_MIRROR = np.asarray((-1.0, 1.0, 1.0))


class Shape(NamedTuple):
    """Vertices and unit normals (n, 3) in the part's space, and openness (n,) where that changes with the pose."""

    vertices: Array
    normals: Array
    openness: Array | None = None


class Motion(NamedTuple):
    """The motion of a part. `state` names what its shape depends on; as long as that stays, the shape does.

    A `shape` that returns the very same normals array as before says that only the vertices have moved.
    """

    shape: Callable[[Pose], Shape]
    state: Callable[[Pose], State]


@dataclass(frozen=True)
class Part:
    """A mesh in one space, with the `shape` and the `state` of its motion."""

    name: str
    space: Space
    faces: Faces
    surface: Surface
    shape: Callable[[Pose], Shape]
    state: Callable[[Pose], State]


def mirrored_shape(shape: Shape, side: int) -> Shape:
    """The shape as it is for side +1, mirrored for side -1."""
    return shape if side > 0 else Shape(shape.vertices * _MIRROR, shape.normals * _MIRROR)


def still(side: int, vertices: Array, normals: Array) -> Motion:
    """Return the motion of a part that never changes its shape."""
    shape = mirrored_shape(Shape(vertices, normals), side)
    return Motion(lambda pose: shape, lambda pose: ())


def cut(part: Part, kept: npt.NDArray[np.bool_]) -> Part:
    """Return the part with only these of its faces, (m,)."""
    used, faces = np.unique(part.faces[kept], return_inverse=True)
    whole = part.surface
    count = len(whole.albedo)

    def of(value: npt.ArrayLike) -> Array:
        return np.asarray(np.broadcast_to(np.asarray(value, float), (count,))[used])

    last: tuple[Array, Array] | None = None

    def shape(pose: Pose) -> Shape:
        nonlocal last
        full = part.shape(pose)
        if last is None or last[0] is not full.normals:
            last = full.normals, full.normals[used]
        return Shape(full.vertices[used], last[1], None if full.openness is None else full.openness[used])

    surface = Surface(whole.albedo[used], of(whole.openness), whole.finish, of(whole.gloss))
    return Part(part.name, part.space, faces.reshape(-1, 3).astype(np.int32), surface, shape, part.state)


def stepped(*values: float) -> State:
    """Values rounded to steps too small to see, so that a part is not made anew for nothing."""
    return tuple([round(value * 250) / 250 for value in values])
