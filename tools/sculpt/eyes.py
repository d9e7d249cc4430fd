"""The eyes: eyeballs with iris and catch-lights, and the lashes and brows that frame them."""

import numpy as np
from openrois_avatar.engines import palette
from openrois_avatar.engines.figure.baked import Piece
from openrois_avatar.engines.figure.eyes import GLINT_SPOKES, GLINTS, brow, lashes
from openrois_avatar.engines.figure.head import DepthMap
from openrois_avatar.engines.figure.mesh import Array, Faces, grid_faces
from openrois_avatar.engines.figure.shading import linear

from tools.sculpt.pieces import both_ways, piece, plain


def pieces(depth: Array) -> list[Piece]:
    """Both eyeballs with catch-lights, lashes and brows, on a face of this depth."""
    return [each for side in (1, -1) for each in (_eyeball(side), _glints(side), _lashes(side), _brow(depth, side))]


def _eyeball(side: int) -> Piece:
    directions, albedo, faces = _ball()
    return piece("eyeball", "head", "eyeball", "plain", faces, albedo, side=side, directions=directions)


def _glints(side: int) -> Piece:
    albedo = np.full((len(GLINTS) * (GLINT_SPOKES + 1), 3), 3.0)
    return piece("catch-lights", "head", "catch-lights", "plain", _GLINT_FACES, albedo, side=side)


def _lashes(side: int) -> Piece:
    rows, columns, _ = lashes(0.0, 0.0, 0.0).shape
    faces = both_ways(grid_faces(rows, columns, closed=False))
    return piece("lashes", "head", "lashes", "plain", faces, plain(palette.LASH, rows * columns), side=side)


def _brow(depth: Array, side: int) -> Piece:
    rows, columns, _ = brow(DepthMap(depth), 0.0, 0.0).shape
    faces = both_ways(grid_faces(rows, columns, closed=False))
    return piece("brow", "head", "brow", "cloth", faces, plain(palette.BROW, rows * columns), side=side, depth=depth)


_BALL_RINGS = np.radians([0, 5, 9, 12, 13.5, 16, 20, 25, 29, 31, 32.5, 37, 46, 58, 72, 86, 98, 108])
_BALL_SPOKES = 36


def _ball() -> tuple[Array, Array, Faces]:
    """Directions (n, 3) from the eye's centre when it looks ahead, their albedo (n, 3), and the faces."""
    turn = np.arange(_BALL_SPOKES) * 2 * np.pi / _BALL_SPOKES
    ring = _BALL_RINGS[:, None]
    directions = np.stack([np.sin(ring) * np.cos(turn), -np.cos(ring) + 0 * turn, np.sin(ring) * np.sin(turn)], axis=-1)
    iris, dark, bright = linear(palette.IRIS), linear(palette.IRIS_DARK), linear(palette.IRIS_BRIGHT)
    random = np.random.default_rng(3)
    streaks = 1 + 0.22 * random.normal(size=_BALL_SPOKES)[:, None]
    # Light from above leaves the iris through its lower half, which is what makes an eye look deep.
    low = np.clip(0.5 - np.sin(turn), 0, 1.5)[:, None] / 1.5
    rows = []
    for angle in np.degrees(_BALL_RINGS):
        if angle < 13:
            colour = np.tile(np.asarray((0.004, 0.006, 0.008)), (_BALL_SPOKES, 1))
        elif angle < 31:
            depth = (angle - 13) / 17
            glow = np.clip(1.25 - abs(depth - 0.45) * 2.2, 0, 1)
            colour = (dark * (1 - glow) + (iris * (1 - low * 0.75) + bright * low * 0.75) * glow) * streaks
        elif angle < 32:
            colour = np.tile(dark * 0.8, (_BALL_SPOKES, 1))
        else:
            colour = np.tile(linear(palette.SCLERA) * (0.86 if angle < 34 else 1.0), (_BALL_SPOKES, 1))
        rows.append(np.clip(colour, 0, 1))
    faces = grid_faces(len(_BALL_RINGS), _BALL_SPOKES, True)[:, ::-1]
    return directions.reshape(-1, 3), np.concatenate(rows), faces


def _fan(start: int) -> list[tuple[int, int, int]]:
    return [(start, start + 1 + (k + 1) % GLINT_SPOKES, start + 1 + k) for k in range(GLINT_SPOKES)]


_GLINT_FACES: Faces = np.asarray([face for n in range(len(GLINTS)) for face in _fan(n * (GLINT_SPOKES + 1))], np.int32)[
    :, ::-1
]
