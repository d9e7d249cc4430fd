"""A part of the figure: a mesh that follows the pose, and how its colours are made."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.sculpt.distance import Array
from openrois_avatar.engines.sculpt.mesh import Faces, Mesh
from openrois_avatar.engines.sculpt.rig import Space
from openrois_avatar.engines.sculpt.shading import Finish, Surface, linear

State = tuple[float, ...]
_MIRROR = np.asarray((-1.0, 1.0, 1.0))


class Shape(NamedTuple):
    """Vertices and unit normals (n, 3) in the part's space, and openness (n,) where that changes with the pose."""

    vertices: Array
    normals: Array
    openness: Array | None = None


@dataclass(frozen=True)
class Part:
    """A mesh in one space. `state` names what its shape depends on; as long as that stays, the shape does.

    A `shape` that returns the very same normals array as before says that only the vertices have moved.
    """

    name: str
    space: Space
    faces: Faces
    surface: Surface
    shape: Callable[[Pose], Shape]
    state: Callable[[Pose], State]


def still(name: str, space: Space, mesh: Mesh, finish: Finish, gloss: float = 0.0) -> Part:
    """A part that never changes its shape."""
    surface = Surface(mesh.albedo, mesh.openness, finish, gloss)
    return Part(name, space, mesh.faces, surface, lambda pose: Shape(mesh.vertices, mesh.normals), lambda pose: ())


def mirrored_mesh(mesh: Mesh) -> Mesh:
    """The mesh of the body's other side."""
    return Mesh(mesh.vertices * _MIRROR, mesh.normals * _MIRROR, mesh.faces[:, ::-1], mesh.albedo, mesh.openness)


def mirrored_shape(shape: Shape, side: int) -> Shape:
    """The shape as it is for side +1, mirrored for side -1."""
    return shape if side > 0 else Shape(shape.vertices * _MIRROR, shape.normals * _MIRROR)


def sided(faces: Faces, side: int) -> Faces:
    """Faces wound for the side their vertices are mirrored to."""
    return faces if side > 0 else faces[:, ::-1]


def cut(part: Part, kept: npt.NDArray[np.bool_]) -> Part:
    """What is left of a part with only these of its faces, (m,)."""
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


def both_ways(faces: Faces) -> Faces:
    """Faces that are seen from both sides."""
    return np.concatenate([faces, faces[:, ::-1]])


def plain(colour: str, count: int, finish: Finish, openness: npt.ArrayLike = 1.0) -> Surface:
    """A surface of one colour."""
    return Surface(np.tile(linear(colour), (count, 1)), openness, finish, 0.0)


def stepped(*values: float) -> State:
    """Values rounded to steps too small to see, so that a part is not made anew for nothing."""
    return tuple([round(value * 250) / 250 for value in values])


def towards(normals: Array, axis: Array) -> Array:
    """Normals turned over where they point away from `axis`, shape (..., 3) or (3,)."""
    against = (normals * axis).sum(axis=-1, keepdims=True) < 0
    return np.asarray(np.where(against, -normals, normals))
