"""Lines and outlines as arrays of points (n, dimensions)."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Points = Sequence[Sequence[float]] | Array


def spline(points: Points, steps: int = 6) -> Array:
    """A smooth open line (Catmull-Rom) through the points, with so many pieces between each two."""
    through = np.asarray(points, float)
    padded = np.concatenate([2 * through[:1] - through[1:2], through, 2 * through[-1:] - through[-2:-1]])
    return _through(padded, steps)


def even(points: Points, count: int) -> Array:
    """So many points at even distances along the smooth open line through the given ones."""
    line = spline(points, 12)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    wanted = np.linspace(0.0, length[-1], count)
    return np.stack([np.interp(wanted, length, part) for part in line.T], axis=1)


def ring(points: Points, steps: int = 6) -> Array:
    """A smooth closed line through the points."""
    through = np.asarray(points, float)
    return _through(np.concatenate([through[-1:], through, through[:2]]), steps)[:-1]


def _through(padded: Array, steps: int) -> Array:
    """The line through all the points but the first and the last."""
    count = len(padded) - 3
    position = np.arange(count * steps + 1) / steps
    part = np.minimum(position.astype(np.intp), count - 1)
    t = (position - part)[:, None]
    a, b, c, d = (padded[part + shift] for shift in range(4))
    return np.asarray(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - 3 * c + d - a) * t**3))


def mirrored(points: Points) -> Array:
    """The points on the other side of the body, in the opposite order, so that an outline can go on with them."""
    other = np.array(points, float)[::-1]
    other[:, 0] *= -1
    return other


def ribbon(line: Array, widths: Array | float) -> Array:
    """The outline of a stroke along a line in the plane, with its half width at every point or at all."""
    along = np.empty_like(line)
    along[1:-1], along[0], along[-1] = line[2:] - line[:-2], line[1] - line[0], line[-1] - line[-2]
    offset = along[:, ::-1] * (-1.0, 1.0)
    offset *= (widths / np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9))[:, None]
    return np.concatenate([line + offset, (line - offset)[::-1]])


def ellipse(centre: Sequence[float], radii: Sequence[float], count: int = 28) -> Array:
    """An ellipse in the picture's plane: centre (x, depth, z) and radii (x, z)."""
    angle = np.arange(count) * 2 * np.pi / count
    x, y, z = centre
    return np.stack([x + radii[0] * np.cos(angle), np.full(count, y), z + radii[1] * np.sin(angle)], axis=1)
