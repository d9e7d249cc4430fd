"""The hair: locks that grow from a parting and sweep over the skull, as one still mesh.

A lock is a flattened tube along a curve. Curves are interpolated between a few guides drawn by hand, so that
neighbouring locks flow together; small seeded differences keep them from looking combed by a machine.
"""

from dataclasses import dataclass

import numpy as np
from openrois_avatar.engines import palette
from openrois_avatar.engines.figure.baked import Piece
from openrois_avatar.engines.figure.mesh import Array, Mesh, crossed, grid_faces, grid_normals, smooth
from openrois_avatar.engines.figure.shading import HALFWAY, linear

from tools.sculpt.distance import ellipsoid, gradient, join
from tools.sculpt.head import face_field
from tools.sculpt.mesh import compact, merged, polygonised, without
from tools.sculpt.paint import Shadow
from tools.sculpt.pieces import still

_SEED, _LOCKS, _RINGS = 11, 12, 15
_SECTION = 6
_CENTRE = np.asarray((0.0, 0.15, 0.10))
"""The middle of the head: what faces it is never seen."""


@dataclass(frozen=True)
class Guide:
    """A curve the hair follows, root to tip (k, 3), and the half width and half thickness of locks near it."""

    points: tuple[tuple[float, float, float], ...]
    width: float
    thick: float


# The parting is a little to the picture's left. Points: root, crown, side, ear, below, tip.
_FALLING = (
    Guide(
        (
            (-0.30, -0.72, 0.98),
            (0.06, -0.92, 0.84),
            (0.42, -0.92, 0.55),
            (0.72, -0.70, 0.20),
            (0.87, -0.44, -0.20),
            (0.69, -0.47, -0.66),
        ),
        0.150,
        0.060,
    ),
    Guide(
        (
            (-0.26, -0.52, 1.14),
            (0.16, -0.84, 1.02),
            (0.60, -0.76, 0.68),
            (0.88, -0.44, 0.24),
            (0.98, -0.24, -0.24),
            (0.74, -0.34, -0.80),
        ),
        0.165,
        0.075,
    ),
    Guide(
        (
            (-0.24, -0.28, 1.24),
            (0.28, -0.46, 1.22),
            (0.78, -0.38, 0.80),
            (1.01, -0.12, 0.26),
            (1.06, -0.02, -0.30),
            (0.74, -0.16, -0.90),
        ),
        0.180,
        0.085,
    ),
    Guide(
        (
            (-0.22, 0.08, 1.31),
            (0.32, 0.04, 1.28),
            (0.82, 0.12, 0.84),
            (1.03, 0.24, 0.26),
            (1.07, 0.30, -0.34),
            (0.68, 0.08, -0.96),
        ),
        0.190,
        0.085,
    ),
    Guide(
        (
            (-0.20, 0.45, 1.24),
            (0.28, 0.52, 1.20),
            (0.74, 0.62, 0.78),
            (0.90, 0.70, 0.22),
            (0.92, 0.72, -0.40),
            (0.66, 0.50, -0.97),
        ),
        0.200,
        0.085,
    ),
    Guide(
        (
            (-0.16, 0.70, 1.10),
            (0.12, 0.92, 0.96),
            (0.34, 1.06, 0.62),
            (0.44, 1.08, 0.10),
            (0.46, 1.04, -0.48),
            (0.32, 0.76, -1.00),
        ),
        0.210,
        0.085,
    ),
)
_TUCKED = (
    Guide(
        (
            (-0.24, -0.72, 0.97),
            (-0.52, -0.80, 0.84),
            (-0.74, -0.56, 0.50),
            (-0.88, -0.14, 0.24),
            (-0.93, 0.17, -0.14),
            (-0.72, 0.04, -0.70),
        ),
        0.120,
        0.055,
    ),
    Guide(
        (
            (-0.28, -0.50, 1.13),
            (-0.58, -0.66, 0.98),
            (-0.84, -0.40, 0.62),
            (-0.97, 0.02, 0.26),
            (-1.00, 0.26, -0.20),
            (-0.74, 0.06, -0.83),
        ),
        0.150,
        0.070,
    ),
    Guide(
        (
            (-0.26, -0.25, 1.24),
            (-0.62, -0.32, 1.10),
            (-0.93, -0.12, 0.70),
            (-1.03, 0.14, 0.24),
            (-1.05, 0.32, -0.28),
            (-0.72, 0.10, -0.91),
        ),
        0.170,
        0.080,
    ),
    Guide(
        (
            (-0.26, 0.10, 1.30),
            (-0.63, 0.12, 1.14),
            (-0.94, 0.24, 0.72),
            (-1.03, 0.36, 0.20),
            (-1.04, 0.44, -0.34),
            (-0.66, 0.18, -0.96),
        ),
        0.185,
        0.085,
    ),
    Guide(
        (
            (-0.24, 0.45, 1.23),
            (-0.54, 0.56, 1.08),
            (-0.82, 0.66, 0.70),
            (-0.91, 0.74, 0.16),
            (-0.91, 0.76, -0.42),
            (-0.65, 0.50, -0.98),
        ),
        0.200,
        0.085,
    ),
    Guide(
        (
            (-0.22, 0.70, 1.08),
            (-0.30, 0.92, 0.94),
            (-0.42, 1.06, 0.60),
            (-0.46, 1.08, 0.08),
            (-0.46, 1.04, -0.50),
            (-0.32, 0.76, -1.01),
        ),
        0.210,
        0.085,
    ),
)
_CLEAR = 0.085
"""How far the middle of a lock stays above the skin, at least."""


def _spline(points: Array, count: int) -> Array:
    """`count` points along a Catmull-Rom curve through the given ones."""
    padded = np.concatenate([2 * points[:1] - points[1:2], points, 2 * points[-1:] - points[-2:-1]])
    position = np.linspace(0, len(points) - 1 - 1e-9, count)
    part = position.astype(np.intp)
    t = (position - part)[:, None]
    a, b, c, d = (padded[part + shift] for shift in range(4))
    return np.asarray(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - 3 * c + d - a) * t**3))


def _lifted(curve: Array) -> Array:
    """The curve pushed out of the skull where it comes too close, and drawn onto it near the root."""
    for _ in range(3):
        distance = face_field(curve)
        normals = gradient(face_field, curve, 0.02)
        near = np.linspace(1.0, 0.0, len(curve)) ** 0.7 * 0.5
        wanted = np.where(
            distance < _CLEAR, _CLEAR, distance * (1 - near) + np.maximum(_CLEAR + 0.03, distance * 0.6) * near
        )
        curve = curve + normals * (wanted - distance)[:, None]
    return curve


def lock(curve: Array, width: float, thick: float, centre: Array) -> tuple[Array, Array]:
    """A flattened tube along the curve, tapering to its tip: grid (n, section, 3) and its normals."""
    along = np.gradient(curve, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    outward = curve - centre
    outward -= np.einsum("ij,ij->i", outward, along)[:, None] * along
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    across = crossed(outward, along)
    s = np.linspace(0, 1, len(curve))[:, None, None]
    profile = (
        np.clip(0.45 + 2.0 * s, 0, 1) * np.sqrt(np.clip(1 - np.clip((s - 0.78) / 0.22, 0, 1) ** 2.2, 0, 1)) + 0.015
    )
    angle = (np.arange(_SECTION) * 2 * np.pi / _SECTION)[None, :, None]
    grid = curve[:, None] + profile * (
        across[:, None] * np.cos(angle) * width + outward[:, None] * np.sin(angle) * thick
    )
    return grid, grid_normals(grid, True)


def locks() -> list[tuple[Array, Array, Array]]:
    """Every lock: grid, normals and brightness (rings, section)."""
    random = np.random.default_rng(_SEED)
    result = []
    for guides in (_FALLING, _TUCKED):
        curves = np.stack([_spline(np.asarray(guide.points), _RINGS) for guide in guides])
        sizes = np.asarray([(guide.width, guide.thick) for guide in guides])
        for layer in (1, 0):
            for step in range(_LOCKS - layer * 2):
                position = (step + 0.5 * layer) / (_LOCKS - 1) * (len(guides) - 1)
                first = min(int(position), len(guides) - 2)
                share = position - first
                curve = curves[first] * (1 - share) + curves[first + 1] * share
                width, thick = sizes[first] * (1 - share) + sizes[first + 1] * share
                late = np.linspace(0, 1, _RINGS)[:, None] ** 1.8
                drift = late * random.normal(0, (0.025, 0.025, 0.03))
                outward = (curve - np.asarray((0, 0.1, 0.2))) * (0.032 * layer + random.uniform(-0.006, 0.010))
                shaped = _lifted(curve + drift + outward)
                shaped = _spline(shaped[: _RINGS - int(random.integers(0, 2))], _RINGS)
                grid, normals = lock(shaped, width * random.uniform(0.85, 1.15), thick, _CENTRE)
                result.append((grid, normals, _strands(shaped, random)))
    return result


def _strands(curve: Array, random: np.random.Generator) -> Array:
    """Brightness (rings, section) of a lock: dark roots and tips, streaks along it, and the band where hair shines."""
    s = np.linspace(0, 1, len(curve))[:, None]
    along = np.gradient(curve, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    shine = np.clip(1 - (along @ HALFWAY) ** 2, 0, 1)[:, None] ** 14
    streaks = 1 + 0.10 * random.normal(size=(1, _SECTION)) + 0.10 * random.normal()
    return np.asarray((0.72 + 0.34 * np.sin(np.pi * np.clip(s * 1.05, 0, 1)) + 0.30 * shine) * streaks)


def cap_field(points: Array) -> Array:
    """The scalp under the locks, which fills the gaps between them."""
    crown = ellipsoid(points, (0, 0.14, 0.36), (0.90, 0.99, 0.95))
    back = ellipsoid(points, (0, 0.45, -0.20), (0.88, 0.62, 0.78))
    whole = join(crown, back, 0.3)
    # The face stays free: nothing in front of a slanted plane below the hairline.
    hairline = -(points[:, 1] + 0.42) + 0.9 * (0.66 - points[:, 2]) * (points[:, 2] < 0.66) * 0.55
    return np.maximum(whole, hairline)


class Hair:
    """The whole hair as one still piece, and the shadow it throws."""

    def __init__(self) -> None:
        base = linear(palette.HAIR)
        meshes, centres = [], []
        for grid, normals, bright in locks():
            points, flat = grid.reshape(-1, 3), normals.reshape(-1, 3)
            faces = grid_faces(bright.shape[0], bright.shape[1], closed=True)
            outward = points - _CENTRE
            # Behind the neck the inner side is the one that is seen.
            unseen = np.einsum("ij,ij->i", flat, outward) < -0.5 * np.linalg.norm(outward, axis=1)
            faces = without(faces, unseen & (points[:, 1] < 0.2) & (points[:, 2] < 0.9))
            albedo = bright.reshape(-1, 1) * base
            meshes.append(compact(Mesh(points, flat, faces, albedo, np.ones(bright.size))))
            centres.append(grid[::2].mean(axis=1))
        points, normals, faces = polygonised(cap_field, (-1.1, -1.0, -1.1), (1.1, 1.3, 1.5), 0.12)
        # Behind, nothing but the cap is between the locks of both sides.
        behind = smooth((points[:, 1] - 0.5) / 0.3)
        meshes.append(Mesh(points, normals, faces, base * (0.60 + 0.32 * behind[:, None]), 0.5 + 0.4 * behind))
        self._mesh = merged(meshes)
        fringe = np.concatenate(centres)
        self.shadow = Shadow(fringe[(fringe[:, 1] < 0.1) & (fringe[:, 2] > -0.3)], 0.17)

    def piece(self) -> Piece:
        """The hair, in head space."""
        return still("hair", "head", "hair", self._mesh, 0.10)
