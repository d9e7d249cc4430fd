"""Meshes as arrays: boxes, planes, discs and bodies of revolution, with the light of the rooms baked in. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

__all__ = ["Mesh", "ball", "box", "disc", "lit", "plane", "tube"]

Floats = NDArray[np.float32]
Colour = tuple[float, float, float]

_SUN: Final = np.asarray((0.35, -0.55, 0.76), np.float32)
"""Direction to the light, of length 1."""
_AMBIENT: Final = 0.62
_LOW: Final = 0.82
"""Light directly over the floor, of that from `_HIGH` metres on: corners are darker."""
_HIGH: Final = 0.7


@dataclass(frozen=True, slots=True)
class Mesh:
    """Triangles.

    Attributes:
        vertices: (n, 3) in metres.
        colours: (n, 3) from 0 to 1.
        places: (n, 2) where in a texture each vertex is, from 0 to 1.
        faces: (m, 3) indices, counter-clockwise as seen from outside.
    """

    vertices: Floats
    colours: Floats
    places: Floats
    faces: NDArray[np.uint16]

    @classmethod
    def joined(cls, meshes: Sequence["Mesh"]) -> Self:
        """Return all of them as one."""
        first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
        return cls(
            np.concatenate([mesh.vertices for mesh in meshes]),
            np.concatenate([mesh.colours for mesh in meshes]),
            np.concatenate([mesh.places for mesh in meshes]),
            np.concatenate([mesh.faces + np.uint16(at) for mesh, at in zip(meshes, first, strict=True)]),
        )

    def turned(self, angle: float, x: float, y: float) -> "Mesh":
        """Return it turned around the vertical axis, by radians to the left, and moved there."""
        rotation = np.asarray([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
        vertices = (self.vertices @ rotation + (x, y, 0)).astype(np.float32)
        return Mesh(vertices, self.colours, self.places, self.faces)


def lit(vertices: Floats, normals: Floats, colour: Colour) -> Floats:
    """Return the colours of vertices of a surface in the light of the rooms."""
    towards = np.clip(normals @ _SUN, 0.0, 1.0)
    light = _AMBIENT + (1 - _AMBIENT) * towards
    light = light * (_LOW + (1 - _LOW) * np.clip(vertices[:, 2] / _HIGH, 0.0, 1.0))
    return np.asarray(np.clip(light[:, None] * np.asarray(colour, np.float32), 0.0, 1.0), np.float32)


def plane(corner: Sequence[float], along: Sequence[float], up: Sequence[float], colour: Colour, step: float) -> Mesh:
    """Return a rectangle from a corner; its front is where `along` turned to `up` is counter-clockwise.

    Args:
        corner: (3,) in metres.
        along: (3,) from it to the next corner.
        up: (3,) from it to the last corner.
        colour: of the surface.
        step: metres from vertex to vertex at most; light changes only from one to the next.
    """
    origin, a, b = (np.asarray(each, np.float32) for each in (corner, along, up))
    columns, rows = (max(1, int(np.ceil(np.linalg.norm(each) / step))) for each in (a, b))
    v, u = (
        each.ravel() for each in np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    )
    vertices = (origin + u[:, None] * a + v[:, None] * b).astype(np.float32)
    normal = np.cross(a, b)
    normals = np.broadcast_to(normal / np.linalg.norm(normal), vertices.shape).astype(np.float32)
    return Mesh(
        vertices, lit(vertices, normals, colour), np.stack([u, v], axis=1).astype(np.float32), _grid(rows, columns)
    )


def box(low: Sequence[float], high: Sequence[float], colour: Colour, step: float = 0.6) -> Mesh:
    """Return a box without its underside, from its lowest corner to its highest."""
    (x, y, z), (right, top, up) = low, high
    wide, deep, tall = (right - x, 0, 0), (0, top - y, 0), (0, 0, up - z)
    return Mesh.joined(
        [
            plane((x, y, z), wide, tall, colour, step),
            plane((right, y, z), deep, tall, colour, step),
            plane((right, top, z), (-wide[0], 0, 0), tall, colour, step),
            plane((x, top, z), (0, -deep[1], 0), tall, colour, step),
            plane((x, y, up), wide, deep, colour, step),
        ]
    )


def disc(x: float, y: float, z: float, radius: float, inner: Colour, outer: Colour) -> Mesh:
    """Return a flat disc with one colour in its middle and one at its edge."""
    angles = np.arange(32) * 2 * np.pi / 32
    edge = np.stack([x + radius * np.cos(angles), y + radius * np.sin(angles), np.full(32, z)], axis=1)
    vertices = np.concatenate([[(x, y, z)], edge]).astype(np.float32)
    colours = np.concatenate([[inner], np.broadcast_to(outer, (32, 3))]).astype(np.float32)
    number = np.arange(32)
    faces = np.stack([np.zeros(32, int), number + 1, (number + 1) % 32 + 1], axis=1).astype(np.uint16)
    return Mesh(vertices, colours, np.zeros((33, 2), np.float32), faces)


def tube(profile: Sequence[tuple[float, float, float]], colour: Colour, sides: int = 12, flat: float = 1.0) -> Mesh:
    """Return a body of revolution around the vertical axis.

    Args:
        profile: from bottom to top: height, radius, and how far it is moved forwards (along x).
        colour: of the surface.
        sides: of each ring.
        flat: the radius along x for one along y.
    """
    angles = np.linspace(0, 2 * np.pi, sides + 1)
    height, radius, ahead = (np.asarray(each, np.float32)[:, None] for each in zip(*profile, strict=True))
    ring = np.stack([np.cos(angles), np.sin(angles)]).astype(np.float32)
    x, y = radius * ring[0] * flat + ahead, radius * ring[1]
    vertices = np.stack([x, y, np.broadcast_to(height, x.shape)], axis=-1).reshape(-1, 3).astype(np.float32)
    slope = -np.gradient(radius[:, 0]) / np.maximum(np.gradient(height[:, 0]), 1e-3)
    normals = np.stack([*np.broadcast_arrays(ring[0], ring[1], slope[:, None])], axis=-1).reshape(-1, 3)
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    u, v = np.meshgrid(np.linspace(0, 1, sides + 1), np.linspace(0, 1, len(profile)))
    places = np.stack([u, v], axis=-1).reshape(-1, 2).astype(np.float32)
    return Mesh(vertices, lit(vertices, normals, colour), places, _grid(len(profile) - 1, sides))


def ball(
    height: float, wide: float, tall: float, colour: Colour, deep: float | None = None, ahead: float = 0.0
) -> Mesh:
    """Return an ellipsoid over the origin; its texture's middle is ahead, along x.

    Args:
        height: of its middle, in metres.
        wide: its radius along y.
        tall: its radius upwards.
        colour: of the surface.
        deep: its radius along x; as wide if not given.
        ahead: how far it is moved along x.
    """
    rows, columns = 10, 16
    polar = np.linspace(-np.pi / 2, np.pi / 2, rows + 1)[:, None]
    # From behind over the figure's right side, ahead, its left side: the texture is seen from ahead, so it is mirrored.
    around = np.linspace(-np.pi, np.pi, columns + 1)[None]
    normal = np.stack(
        np.broadcast_arrays(np.cos(polar) * np.cos(around), np.cos(polar) * np.sin(around), np.sin(polar)), axis=-1
    ).reshape(-1, 3)
    radii = np.asarray((wide if deep is None else deep, wide, tall))
    vertices = (normal * radii + (ahead, 0, height)).astype(np.float32)
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    places = np.stack([u, v], axis=-1).reshape(-1, 2).astype(np.float32)
    return Mesh(vertices, lit(vertices, normal.astype(np.float32), colour), places, _grid(rows, columns))


def _grid(rows: int, columns: int) -> NDArray[np.uint16]:
    """Return the triangles of a grid of vertices, row by row."""
    first = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    above = first + columns + 1
    lower, upper = np.stack([first, first + 1, above + 1], axis=1), np.stack([first, above + 1, above], axis=1)
    return np.concatenate([lower, upper]).astype(np.uint16)
