"""From the body's decimetres to the drawing's pixels, framed as the sculpted figure is."""

from dataclasses import dataclass, replace
from math import atan2, cos, sin
from typing import Final

import numpy as np

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.puppet.curves import Array, Points
from openrois_avatar.engines.sculpt.rig import Frame, body_frame, head_frame

_DISTANCE: Final = 15.0
_SPAN: Final = 4.7
"""From the eye to the head, and the height of the picture there, in dm."""
_EYE_LEVEL: Final = -0.66
_CALM: Final = 0.78
"""A flat face turns less than a solid one, else it slips under the hair."""


@dataclass(frozen=True)
class Lens:
    """Where a drawing of so many pixels shows the world."""

    width: int
    height: int

    @property
    def scale(self) -> float:
        """Pixels per decimetre at the head."""
        return self.height / _SPAN

    def seen(self, world: Array) -> Array:
        """Points (n, 3) in pixels (n, 2), rightwards and downwards."""
        near = self.scale * _DISTANCE / np.maximum(_DISTANCE + world[:, 1], 1.0)
        pixels = np.empty((len(world), 2))
        pixels[:, 0] = self.width / 2 + world[:, 0] * near
        pixels[:, 1] = self.height / 2 - (world[:, 2] - _EYE_LEVEL) * near
        return pixels


@dataclass(frozen=True)
class Space:
    """A space of the figure, seen through the lens."""

    frame: Frame
    lens: Lens

    def __call__(self, points: Points) -> Array:
        """Points (n, 3) of the space in pixels (n, 2)."""
        return self.lens.seen(np.asarray(points, float) @ self.frame.rotation.T + self.frame.origin)

    def pixels(self, length: float, point: Points = ((0.0, 0.0, 0.0),)) -> float:
        """How long so many decimetres at a point of the space are."""
        depth = (np.asarray(point, float) @ self.frame.rotation.T + self.frame.origin)[0, 1]
        return float(length * self.lens.scale * _DISTANCE / max(_DISTANCE + depth, 1.0))


@dataclass(frozen=True)
class View:
    """The spaces of the figure in a pose.

    `head` turns as a solid does. `round` is for the outlines of round things: it moves what is near or far as the head
    turns, and tilts, but never gets narrower.
    """

    body: Space
    head: Space
    round: Space

    @classmethod
    def of(cls, pose: Pose, lens: Lens) -> "View":
        """The view of a pose."""
        calm = replace(
            pose, head_yaw=pose.head_yaw * _CALM, head_pitch=_CALM * (pose.head_pitch - pose.lean) + pose.lean
        )
        body, head = body_frame(pose), head_frame(calm)
        return cls(Space(body, lens), Space(head, lens), Space(_rounded(head), lens))


def _rounded(head: Frame) -> Frame:
    tilt = atan2(head.rotation[0, 2], head.rotation[2, 2])
    rotation = head.rotation.copy()
    rotation[:, 0] = (cos(tilt), 0.0, -sin(tilt))
    rotation[:, 2] = (sin(tilt), 0.0, cos(tilt))
    return Frame(rotation, head.origin)
