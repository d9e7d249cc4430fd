"""The place of each space of the figure in the world, for a pose."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import pi
from typing import Final, Literal

import numpy as np

from openrois_avatar.engines.animation.pose import Leg as LegPose
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure.mesh import Array

NECK = np.asarray((0.0, 0.20, -0.72))
"""The joint the head turns around, in body space."""
SHOULDER = (1.10, 0.30, -1.90)
"""The left shoulder joint."""
HIP, KNEE, ANKLE = (np.asarray(joint) for joint in ((0.47, 0.36, -5.15), (0.49, 0.34, -7.85), (0.50, 0.42, -10.55)))
"""The joints of the left leg of one who stands, in body space; the floor is 0.45 dm below the ankle."""
_HIPS = np.asarray((0.0, 0.45, -5.6))


Leg = Literal["thigh_left", "shin_left", "foot_left", "thigh_right", "shin_right", "foot_right"]
Space = Literal["body", "back", "head", "hand_left", "hand_right", "hips"] | Leg
"""The parts of the figure that move as one: the back of the jumper goes along with the body."""
_LEFT: Final[Sequence[Leg]] = ("thigh_left", "shin_left", "foot_left")
_RIGHT: Final[Sequence[Leg]] = ("thigh_right", "shin_right", "foot_right")


@dataclass(frozen=True)
class Frame:
    """A space in the world: a point p of it is at rotation @ p + origin."""

    rotation: Array
    origin: Array

    def raised(self, height: float) -> "Frame":
        """This frame, so many dm higher."""
        return Frame(self.rotation, self.origin + np.asarray((0.0, 0.0, height)))

    def within(self, outer: "Frame") -> "Frame":
        """This frame, given in the space of `outer`, in the world."""
        return Frame(outer.rotation @ self.rotation, outer.rotation @ self.origin + outer.origin)


def turned(yaw: float, pitch: float, roll: float) -> Array:
    """A rotation: yaw to the right of the picture, pitch up, roll towards the picture's right."""
    cy, sy, cp, sp, cr, sr = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch), np.cos(roll), np.sin(roll)
    aside = np.asarray(((cy, -sy, 0), (sy, cy, 0), (0, 0, 1)))
    up = np.asarray(((1, 0, 0), (0, cp, sp), (0, -sp, cp)))
    over = np.asarray(((cr, 0, sr), (0, 1, 0), (-sr, 0, cr)))
    return np.asarray(aside @ up @ over)


def head_turn(pose: Pose) -> Array:
    """The head's rotation in body space."""
    return turned(pose.head_yaw, pose.head_pitch, pose.head_roll)


def body_frame(pose: Pose) -> Frame:
    """The body, which leans from the hips."""
    return _around(turned(pose.twist, -pose.lean, pose.side), _HIPS)


def head_frame(pose: Pose) -> Frame:
    """The head, which turns on the neck of the leaning body."""
    return _around(head_turn(pose), NECK).within(body_frame(pose))


def shoulder_lift(pose: Pose, side: int) -> float:
    """Return the height of a shoulder above its rest, in dm."""
    return 0.30 * (pose.shoulder_left if side > 0 else pose.shoulder_right)


AT_ORIGIN = Frame(np.eye(3), np.zeros(3))
"""The world itself."""


@lru_cache(maxsize=8)
def leg_frames(left: LegPose, right: LegPose) -> tuple[dict[Leg, Frame], float]:
    """Thighs, shins and feet by name, in body space, and how far (dm) the body rises on its legs: down, if below 0."""
    frames: dict[Leg, Frame] = {}
    soles = []
    for side, spaces, leg in ((1, _LEFT, left), (-1, _RIGHT, right)):
        hip, knee, ankle = (np.asarray((side, 1.0, 1.0)) * joint for joint in (HIP, KNEE, ANKLE))
        thigh = _around(turned(0.0, leg.hip, 0.0), hip)
        bent = turned(0.0, leg.hip - leg.knee, 0.0)
        shin = Frame(bent, thigh.rotation @ knee + thigh.origin - bent @ knee)
        flat = turned(0.0, leg.foot, 0.0)
        foot = Frame(flat, bent @ ankle + shin.origin - flat @ ankle)
        frames.update(zip(spaces, (thigh, shin, foot), strict=True))
        soles.append(float((bent @ ankle + shin.origin)[2]))
    return frames, float(ANKLE[2]) - min(soles)


def standing(x: float, y: float, heading: float) -> Frame:
    """The world of a figure that stands at x, y (dm) with the heading `heading` (radians), -pi/2 towards the viewer."""
    return Frame(turned(heading + pi / 2, 0.0, 0.0), np.asarray((x, y, 0.0)))


def _around(rotation: Array, pivot: Array) -> Frame:
    return Frame(rotation, pivot - rotation @ pivot)
