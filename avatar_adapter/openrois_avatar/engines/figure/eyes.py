"""The motion of the eyes: lids and the skin around them, lashes and brows; eyeballs that turn, and their catch-lights.

Everything is made for the left eye (x > 0) and mirrored. Grids are (rings, spokes, 3); spokes run from the outer
corner over the upper lid to the inner corner and back along the lower lid.
"""

from functools import lru_cache

import numpy as np

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure.head import EYE, EYE_PATCH, EYE_RADIUS, DepthMap, patched
from openrois_avatar.engines.figure.mesh import Array, grid_normals, smooth, towards
from openrois_avatar.engines.figure.part import Motion, Shape, State, mirrored_shape, stepped
from openrois_avatar.engines.figure.rig import turned

SPOKES = 48
HALF_WIDTH, _UPPER, _LOWER = 0.246, 0.150, 0.112
_RINGS = np.asarray([0.0, 0.07, 0.16, 0.26, 0.34, 0.42, 0.55, 0.70, 0.85, 1.0])
_ANGLE = np.arange(SPOKES) * 2 * np.pi / SPOKES
_ACROSS, _HEIGHT = np.cos(_ANGLE), np.sin(_ANGLE)
_IS_UPPER = _HEIGHT >= 0
_AHEAD = np.asarray((0.0, -1.0, 0.0))
_CONVERGENCE = 0.045
"""Radians by which each eye turns inwards to meet the other's gaze."""
GLINT_SPOKES = 12
GLINTS = ((-0.052, 0.062, 0.036), (0.050, -0.056, 0.016))
"""The catch-lights: across, up, and their radius."""


# Lids, lashes and eyeball of an eye ask for it in turn.
@lru_cache(maxsize=4)
def lid_line(lid: float, squint: float, wide: float) -> tuple[Array, Array]:
    """The opening between the lids as (x, z) offsets from the eye's centre, one per spoke; lid 0 open .. 1 closed.

    The arrays are shared: a caller does not change them.
    """
    x = HALF_WIDTH * _ACROSS
    corner = 0.022 * _ACROSS
    arch = np.abs(_HEIGHT) ** 0.85
    upper = corner + (_UPPER + 0.035 * wide) * arch * (1 - 0.10 * _ACROSS)
    lower = corner - _LOWER * arch * (1 + 0.16 * _ACROSS)
    closing = corner - 0.62 * _LOWER * arch
    upper = upper + (closing - upper) * lid
    lower = lower + (closing - lower) * max(lid**2, 0.55 * squint)
    return x, np.where(_IS_UPPER, upper, np.minimum(lower, upper))


class Lids:
    """The skin around the left eye: ring 0 is the inside of the lid's edge, the last ring lies on the face."""

    def __init__(self, depth: DepthMap) -> None:
        self._depth = depth
        self._outer_x = np.where(_ACROSS > 0, EYE_PATCH[0], EYE_PATCH[1]) * _ACROSS
        self._outer_z = EYE_PATCH[2] * _HEIGHT
        self._rest_y = depth(EYE[0] + self._outer_x, EYE[2] + self._outer_z)

    def grid(self, lid: float, squint: float, wide: float) -> Array:
        """Vertices (rings + 1, SPOKES, 3) in head space, left eye."""
        line_x, line_z = lid_line(lid, squint, wide)
        share = _RINGS[:, None]
        x = line_x + (self._outer_x - line_x) * share
        z = line_z + (self._outer_z - line_z) * share
        thick = 0.037 + 0.008 * _HEIGHT
        sunk = 0.05 * share * (1 - _HEIGHT)
        ball = EYE[1] - np.maximum(on_ball(x, z, EYE_RADIUS + thick) - sunk, on_ball(x, z, EYE_RADIUS + 0.012))
        face = self._depth(EYE[0] + x, EYE[2] + z)
        y = _nearer(ball, face, 0.05)
        crease = np.exp(-(((share - 0.30) / 0.10) ** 2)) * np.where(_IS_UPPER, np.abs(_HEIGHT) ** 0.6, 0.0)
        y = y + crease * (0.045 * (1 - lid) + 0.008)
        y[-1] = self._rest_y
        inner_y = EYE[1] - on_ball(line_x, line_z, EYE_RADIUS - 0.005)
        rows = [np.stack([line_x * 0.985, inner_y, line_z * 0.985], axis=1)[None], np.stack([x, y, z], axis=2)]
        grid = np.concatenate(rows)
        grid[:, :, 0] += EYE[0]
        grid[:, :, 2] += EYE[2]
        return grid


def lid_state(pose: Pose, side: int) -> tuple[float, float, float]:
    """Lid, squint and wide of one eye, with the part of it that follows the gaze up and down."""
    return _lid_state(pose.lid_left if side > 0 else pose.lid_right, pose.gaze_pitch, pose.squint, pose.wide)


# Lids, lashes and eyeball of an eye ask for it in turn.
@lru_cache(maxsize=4)
def _lid_state(lid: float, gaze_pitch: float, squint: float, wide: float) -> tuple[float, float, float]:
    follow = max(-gaze_pitch, 0.0) * 0.9 - max(gaze_pitch, 0.0) * 0.4
    values = stepped(min(max(lid + (1 - lid) * follow, -0.15), 1.0), squint, wide)
    return values[0], values[1], values[2]


def lid_motion(side: int, depth: Array, skin_normals: Array) -> Motion:
    """Return the motion of the skin around an eye.

    Args:
        side: +1 is the avatar's left.
        depth: of the face, as `DepthMap` reads it.
        skin_normals: of the face under every vertex of the open left lids, (rings + 1, SPOKES, 3).
    """
    lids = Lids(DepthMap(depth))

    def shape(pose: Pose) -> Shape:
        grid = lids.grid(*lid_state(pose, side))
        return mirrored_shape(Shape(grid.reshape(-1, 3), patched(grid, skin_normals).reshape(-1, 3)), side)

    return Motion(shape, lambda pose: lid_state(pose, side))


def lashes_motion(side: int) -> Motion:
    """Return the motion of the lashes, which follow the upper lid."""
    rows, columns, _ = lashes(0.0, 0.0, 0.0).shape
    normals = np.tile(_AHEAD, (rows * columns, 1))

    def shape(pose: Pose) -> Shape:
        return mirrored_shape(Shape(lashes(*lid_state(pose, side)).reshape(-1, 3), normals), side)

    return Motion(shape, lambda pose: lid_state(pose, side))


def brow_motion(side: int, depth: Array) -> Motion:
    """Return the motion of a brow over the forehead, whose depth `DepthMap` reads."""
    face = DepthMap(depth)

    def state(pose: Pose) -> State:
        return stepped(pose.brow_left if side > 0 else pose.brow_right, pose.frown)

    def shape(pose: Pose) -> Shape:
        lift, frown = state(pose)
        grid = brow(face, lift, frown)
        normals = towards(grid_normals(grid, closed=False), _AHEAD)
        return mirrored_shape(Shape(grid.reshape(-1, 3), normals.reshape(-1, 3)), side)

    return Motion(shape, state)


def lashes(lid: float, squint: float, wide: float) -> Array:
    """The upper lash line as a thin crest along the lid's edge: (3, n, 3), left eye."""
    line_x, line_z = lid_line(lid, squint, wide)
    half = SPOKES // 2 + 1
    x, z, across = line_x[:half], line_z[:half], _ACROSS[:half]
    outward = np.clip((across + 1) / 2, 0, 1)
    thick = 0.012 + 0.022 * smooth(np.asarray(outward * 1.15))
    thick[-1] = 0.004
    wing = np.clip((across - 0.72) / 0.28, 0, 1) ** 1.5
    droop = 1 - 1.7 * lid
    rows = []
    for depth, rise in ((0.040, -0.25), (0.062, 0.45), (0.050, 1.0)):
        px = x + wing * 0.055 * max(rise, 0.0)
        pz = z + thick * rise * (0.35 + 0.65 * max(droop, -0.2)) + wing * 0.035 * max(rise, 0.0)
        rows.append(np.stack([EYE[0] + px, EYE[1] - on_ball(x, z, EYE_RADIUS + depth), EYE[2] + pz], axis=1))
    return np.stack(rows)


def brow(depth: DepthMap, lift: float, frown: float) -> Array:
    """A brow that hugs the forehead: (5, n, 3), left eye; lift -1..1, frown 0..1 draws it in and down."""
    along = np.linspace(0, 1, 15)
    x = 0.150 + 0.455 * along - 0.035 * frown * (1 - along)
    z = 0.235 + 0.125 * np.sin(np.pi * (0.16 + 0.66 * along)) - 0.055 * along**2
    z = z + lift * 0.085 * (0.75 + 0.25 * np.sin(np.pi * along)) - frown * 0.085 * (1 - along) ** 1.5
    thick = 0.037 * np.sqrt(np.clip(1.12 - along, 0, 1)) * smooth(np.asarray(0.35 + along * 6))
    rows = []
    for rise, bulge in ((-1.0, -0.004), (-0.55, 0.020), (0.0, 0.028), (0.55, 0.020), (1.0, -0.004)):
        pz = z + rise * thick
        rows.append(np.stack([x, depth(x, pz) - bulge, pz], axis=1))
    return np.stack(rows)


def on_ball(x: Array, z: Array, radius: float | Array) -> Array:
    """Return how far a ball's surface is before the eye's centre at (x, z); past its edge it falls away quickly."""
    inside = radius**2 - x**2 - z**2
    return np.asarray(np.where(inside > 1e-4, np.sqrt(np.maximum(inside, 1e-4)), 0.01 + inside * 4))


def _nearer(first: Array, second: Array, softness: float) -> Array:
    bridge = np.maximum(softness - np.abs(first - second), 0.0) / softness
    return np.asarray(np.minimum(first, second) - bridge * bridge * softness * 0.25)


def _gaze(pose: Pose, side: int) -> tuple[float, float]:
    yaw, pitch = stepped(pose.gaze_yaw - side * _CONVERGENCE, pose.gaze_pitch)
    return yaw, pitch


def eyeball_motion(side: int, directions: Array) -> Motion:
    """Return the turns of an eyeball with vertices in these directions (n, 3) from its centre when it looks ahead."""
    centre = np.asarray(EYE) * (side, 1, 1)

    def shape(pose: Pose) -> Shape:
        looking = directions @ turned(*_gaze(pose, side), 0.0).T
        shadow = _lid_shadow(looking * EYE_RADIUS * (side, 1, 1), *lid_state(pose, side))
        return Shape(centre + looking * EYE_RADIUS, looking, shadow)

    return Motion(shape, lambda pose: (*_gaze(pose, side), *lid_state(pose, side)))


def glints_motion(side: int) -> Motion:
    """Return the motion of the catch-lights, which stay on the eyeball."""
    centre = np.asarray(EYE) * (side, 1, 1)
    normals = np.tile(_AHEAD, (len(_glints(0.0, 0.0)), 1))

    def shape(pose: Pose) -> Shape:
        return Shape(centre + _glints(*_gaze(pose, side)), normals)

    return Motion(shape, lambda pose: _gaze(pose, side))


def _lid_shadow(offsets: Array, lid: float, squint: float, wide: float) -> Array:
    """Openness (n,) of the eyeball's surface at offsets (n, 3) from its centre: the upper lid shades it."""
    line_x, line_z = lid_line(lid, squint, wide)
    half = SPOKES // 2 + 1
    upper = np.interp(offsets[:, 0], line_x[:half][::-1], line_z[:half][::-1])
    lower = np.interp(offsets[:, 0], line_x[half - 1 :], line_z[half - 1 :])
    under = np.clip((upper - offsets[:, 2]) / 0.10, 0, 1)
    over = np.clip((offsets[:, 2] - lower) / 0.05, 0, 1)
    corner = np.clip((HALF_WIDTH - np.abs(offsets[:, 0])) / 0.09, 0, 1)
    return np.asarray((0.30 + 0.70 * under) * (0.75 + 0.25 * over) * (0.70 + 0.30 * corner))


def _glints(yaw: float, pitch: float) -> Array:
    """The catch-lights as small discs, offsets (n, 3) from the eye's centre; they follow the gaze only in part."""
    x, z = 0.75 * EYE_RADIUS * np.sin(yaw), 0.75 * EYE_RADIUS * np.sin(pitch)
    turn = np.arange(GLINT_SPOKES) * 2 * np.pi / GLINT_SPOKES
    points = []
    for across, up, size in GLINTS:
        disc = np.stack([across + x + size * np.cos(turn), up + z + size * np.sin(turn)], axis=1)
        flat = np.concatenate([[[across + x, up + z]], disc])
        points.append(np.stack([flat[:, 0], -on_ball(flat[:, 0], flat[:, 1], EYE_RADIUS + 0.012), flat[:, 1]], axis=1))
    return np.concatenate(points)
