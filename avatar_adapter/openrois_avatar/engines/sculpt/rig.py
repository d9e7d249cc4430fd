"""Where each space of the figure is in the world for a pose."""

from dataclasses import dataclass

import numpy as np

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.sculpt.distance import Array

NECK = np.asarray((0.0, 0.20, -0.72))
"""The joint the head turns around, in body space."""
_HIPS = np.asarray((0.0, 0.45, -5.6))


@dataclass(frozen=True)
class Frame:
    """A space in the world: a point p of it is at rotation @ p + origin."""

    rotation: Array
    origin: Array

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


def _around(rotation: Array, pivot: Array) -> Frame:
    return Frame(rotation, pivot - rotation @ pivot)
