"""Signed distance fields: the clay the avatar is made of.

A field is a function from points, shape (n, 3) in decimetres, to signed distances, shape (n,): negative inside.
Axes are those of the figure's meshes.
"""

from collections.abc import Callable, Sequence

import numpy as np
from openrois_avatar.engines.figure.mesh import Array

Field = Callable[[Array], Array]
Triple = Sequence[float] | Array


def ellipsoid(points: Array, centre: Triple, radii: Triple) -> Array:
    """Distance to an ellipsoid; exact for a sphere, first-order near the surface otherwise."""
    scaled = (points - np.asarray(centre)) / np.asarray(radii)
    length = np.sqrt(np.einsum("ij,ij->i", scaled, scaled))
    steep = scaled / np.asarray(radii)
    gradient = np.sqrt(np.einsum("ij,ij->i", steep, steep))
    return np.asarray(length * (length - 1.0) / np.maximum(gradient, 1e-9))


def cone(points: Array, start: Triple, end: Triple, radius_start: float, radius_end: float) -> Array:
    """Distance to a capsule whose radius changes linearly from start to end."""
    origin = np.asarray(start, float)
    axis = np.asarray(end, float) - origin
    along = np.clip((points - origin) @ axis / max(float(axis @ axis), 1e-12), 0.0, 1.0)
    offset = points - origin - along[:, None] * axis
    return np.asarray(
        np.sqrt(np.einsum("ij,ij->i", offset, offset)) - (radius_start + (radius_end - radius_start) * along)
    )


def join(first: Array, second: Array, softness: float) -> Array:
    """Union with a fillet about `softness` wide (quadratic smooth minimum)."""
    bridge = np.maximum(softness - np.abs(first - second), 0.0) / softness
    return np.asarray(np.minimum(first, second) - bridge * bridge * softness * 0.25)


def carve(body: Array, tool: Array, softness: float) -> Array:
    """Take `tool` out of `body`, with a rounded edge about `softness` wide."""
    return -join(-body, tool, softness)


def mirrored(points: Array) -> Array:
    """The points folded onto x >= 0, so that a shape sculpted once appears on both sides."""
    folded = points.copy()
    folded[:, 0] = np.abs(folded[:, 0])
    return folded


def gradient(field: Field, points: Array, step: float = 2e-3) -> Array:
    """Unit normals of the field at the points, by central differences."""
    normals = np.empty_like(points)
    for axis in range(3):
        shift = np.zeros(3)
        shift[axis] = step
        normals[:, axis] = field(points + shift) - field(points - shift)
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12))


def march(field: Field, origins: Array, directions: Array, reach: float, steps: int = 40) -> Array:
    """Return the distance along each ray to its first meeting with the surface, at most `reach`."""
    travelled = np.zeros(len(origins))
    for _ in range(steps):
        travelled += field(origins + travelled[:, None] * directions) * 0.9
        np.clip(travelled, 0.0, reach, out=travelled)
    return travelled


def occlusion(field: Field, points: Array, normals: Array, span: float = 0.5) -> Array:
    """Return the openness of the surface, 0 (in a fold) to 1 (free), from the field along the normal."""
    closed = np.zeros(len(points))
    for step in range(1, 6):
        distance = span * step / 5
        closed += (distance - np.clip(field(points + normals * distance), 0.0, distance)) / distance * 0.5**step
    return np.asarray(np.clip(1.0 - closed, 0.0, 1.0))
