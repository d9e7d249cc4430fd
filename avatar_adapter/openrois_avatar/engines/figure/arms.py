"""Arms: two bones solved towards a wrist, and the sleeve around them."""

from dataclasses import dataclass
from functools import lru_cache
from math import cos, hypot, sin, sqrt
from typing import Final, TypeAlias

import numpy as np

from openrois_avatar.engines.animation.pose import Arm, Pose
from openrois_avatar.engines.figure.mesh import Array, crossed
from openrois_avatar.engines.figure.part import Motion, Shape, State, mirrored_shape, stepped
from openrois_avatar.engines.figure.rig import SHOULDER, shoulder_lift

_Vector: TypeAlias = tuple[float, float, float]

UPPER_LENGTH, FORE_LENGTH = 1.50, 1.38
_PALM_TOWARDS: Final = (0.0, -1.0, -0.5)
"""Where the palm faces without twist, as far as the forearm lets it."""
_ELBOW_TOWARDS: Final = (-0.35, 0.50, -1.00)
_DELTOID: Final = np.asarray((-0.80, 0.30, -2.10))
"""The middle of the roundness that sleeve and jumper share at the shoulder."""
RINGS, SECTION, _SEAM = 30, 14, 12
"""Rings of a sleeve, vertices around it, and how many rings may touch the jumper."""
_OUT_OF_SIGHT = -3.75
"""A wrist below this height (dm) is under the close view."""
_DOME = 0.325
"""Radius of the shoulder, in dm."""
ALONG = np.concatenate([-_DOME / UPPER_LENGTH * np.cos(np.linspace(0.02, 1.2, 6)), np.linspace(-0.02, 1.97, RINGS - 6)])
_RADIUS = np.where(
    ALONG < 0.0,
    np.sqrt(np.maximum(_DOME**2 - (ALONG * UPPER_LENGTH) ** 2, 0.0)),
    np.interp(ALONG, [0.0, 0.35, 0.9, 1.3, 1.82, 1.86, 1.97], [_DOME, 0.295, 0.26, 0.25, 0.21, 0.23, 0.22]),
)


@dataclass(frozen=True)
class Chain:
    """A solved right arm in body space: joints, and the hand's axes as columns (towards thumb, back, fingers)."""

    shoulder: Array
    elbow: Array
    wrist: Array
    hand: Array


@lru_cache(maxsize=8)
def solve(arm: Arm, lift: float) -> Chain:
    """Joints of the right arm, its shoulder raised by `lift` dm; it goes as far towards its target as it reaches."""
    shoulder: _Vector = (-SHOULDER[0], SHOULDER[1], SHOULDER[2] + lift)
    reach = (-arm.out - shoulder[0], arm.y - shoulder[1], arm.z - shoulder[2])
    distance = min(max(hypot(*reach), 0.5), (UPPER_LENGTH + FORE_LENGTH) * 0.998)
    direction = _unit(reach)
    along = (UPPER_LENGTH**2 - FORE_LENGTH**2 + distance**2) / (2 * distance)
    height = sqrt(max(UPPER_LENGTH**2 - along**2, 0.0))
    pole = _turned(_unit(_aside(_ELBOW_TOWARDS, direction)), direction, arm.swivel)
    elbow = _sum(shoulder, (along, direction), (height, pole))
    wrist = _sum(shoulder, (distance, direction))
    forearm = _unit(_sum(wrist, (-1.0, elbow)))
    return Chain(np.asarray(shoulder), np.asarray(elbow), np.asarray(wrist), _hand_frame(arm, forearm))


def _hand_frame(arm: Arm, fingers: _Vector) -> Array:
    palm = _turned(_unit(_aside(_PALM_TOWARDS, fingers)), fingers, arm.twist)
    thumb = _cross(fingers, palm)
    fingers, palm = _turned(fingers, thumb, -arm.bend), _turned(palm, thumb, -arm.bend)
    fingers, thumb = _turned(fingers, palm, arm.side), _turned(thumb, palm, arm.side)
    back = (-palm[0], -palm[1], -palm[2])
    return np.asarray((thumb, back, fingers)).T


def _sum(start: _Vector, *steps: tuple[float, _Vector]) -> _Vector:
    x, y, z = start
    for length, (dx, dy, dz) in steps:
        x, y, z = x + length * dx, y + length * dy, z + length * dz
    return x, y, z


def _dot(a: _Vector, b: _Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: _Vector, b: _Vector) -> _Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _unit(vector: _Vector) -> _Vector:
    length = max(hypot(*vector), 1e-6)
    return vector[0] / length, vector[1] / length, vector[2] / length


def _aside(vector: _Vector, axis: _Vector) -> _Vector:
    """Return the part of the vector that is across a unit axis."""
    return _sum(vector, (-_dot(vector, axis), axis))


def _turned(vector: _Vector, axis: _Vector, angle: float) -> _Vector:
    """Rotation of a vector around a unit axis (Rodrigues)."""
    turned = _cross(axis, vector)
    return _sum(
        (0.0, 0.0, 0.0), (cos(angle), vector), (sin(angle), turned), ((1 - cos(angle)) * _dot(axis, vector), axis)
    )


def chain(pose: Pose, side: int) -> Chain:
    """The solved arm of one side (+1: the avatar's left), as if it were the right one."""
    return solve(pose.left if side > 0 else pose.right, shoulder_lift(pose, side))


def raised(arm: Arm) -> bool:
    """Tell whether any of the hand may be in the close view."""
    return arm.z > _OUT_OF_SIGHT


def sleeve_motion(side: int) -> Motion:
    """Return the motion of a sleeve, which follows its arm."""

    def state(pose: Pose) -> State:
        arm = pose.left if side > 0 else pose.right
        return stepped(arm.out, arm.y, arm.z, arm.swivel, shoulder_lift(pose, side))

    def shape(pose: Pose) -> Shape:
        return mirrored_shape(sleeve(chain(pose, side)), -side)

    return Motion(shape, state)


def sleeve(chain: Chain) -> Shape:
    """The right sleeve from inside the shoulder to the cuff."""
    shoulder, elbow, wrist = chain.shoulder, chain.elbow, chain.wrist
    # Before the shoulder the upper arm goes on into a dome.
    first, second = np.clip(ALONG, None, 1.0)[:, None], np.clip(ALONG - 1.0, 0.0, None)[:, None]
    centre = shoulder + (elbow - shoulder) * first + (wrist - elbow) * second
    bend = np.exp(-(((ALONG - 1.0) / 0.22) ** 2))[:, None]
    centre = centre + bend * ((shoulder + wrist) / 2 - elbow) * 0.10
    along = np.gradient(centre, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = crossed(along, np.cross(wrist - elbow, shoulder - elbow) + np.asarray((1e-3, 0, 0)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    other = crossed(along, across)
    angle = np.arange(SECTION) * 2 * np.pi / SECTION
    ring = across[:, None] * np.cos(angle)[None, :, None] + other[:, None] * np.sin(angle)[None, :, None]
    points = centre[:, None] + ring * _RADIUS[:, None, None]
    normals = ring.reshape(-1, 3).copy()
    seam = _SEAM * SECTION
    normals[:seam] = _seamless(points[:_SEAM].reshape(-1, 3), normals[:seam])
    return Shape(points.reshape(-1, 3), normals)


def _seamless(points: Array, normals: Array) -> Array:
    """Normals that turn into the shoulder's where the sleeve meets the jumper, so that light does not show the seam."""
    outward = points - _DELTOID
    outward[:, 2] = np.maximum(outward[:, 2], 0.0)
    distance = np.linalg.norm(outward, axis=1, keepdims=True)
    share = np.clip((0.80 - distance) / 0.40, 0, 1)
    mixed = normals * (1 - share) + outward / distance * share
    return np.asarray(mixed / np.linalg.norm(mixed, axis=1, keepdims=True))
