"""From the body's decimetres to the drawing's pixels, framed as the sculpted figure is."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import atan2, cos, pi, sin
from typing import Final

import numpy as np

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure.rig import Frame, Leg, body_frame, head_frame, leg_frames, standing
from openrois_avatar.engines.puppet.curves import Array, Points
from openrois_avatar.engines.room.plan import HOME
from openrois_avatar.engines.room.shot import DISTANCE, HOME_SHOT, METRE, SPAN, Shot
from openrois_avatar.link.messages import Place

_HEAD_ASIDE, _BODY_ASIDE = 0.42, 0.30
"""How far head and body turn, in radians, when the figure goes to the side."""
_BEHIND: Final = -0.35
"""The cosine of its turn from the viewer beyond which a figure is seen from behind."""
_CALM: Final = 0.78
"""A flat face turns less than a solid one, else it slips under the hair."""


@dataclass(frozen=True)
class Lens:
    """The projection of the world to the pixels of a drawing, for a shot."""

    width: int
    height: int
    shot: Shot = HOME_SHOT

    @property
    def scale(self) -> float:
        """Pixels per decimetre at the head in the close view."""
        return self.height / SPAN

    def depths(self, world: Array) -> Array:
        """Return the depths of points (n, 3) along the camera's sight, in dm and at least 1."""
        tilt, away = self.shot.tilt, world[:, 1] - self.shot.y
        if tilt:
            away = away * cos(tilt) - (world[:, 2] - self.shot.z) * sin(tilt)
        return np.maximum(away, 1.0)

    def unit(self, world: Array) -> Array:
        """Pixels per decimetre at points (n, 3)."""
        return np.asarray(self.scale * DISTANCE / self.depths(world))

    def seen(self, world: Array) -> Array:
        """Points (n, 3) in pixels (n, 2), rightwards and downwards."""
        shot, near = self.shot, self.unit(world)
        pixels = np.empty((len(world), 2))
        pixels[:, 0] = self.width / 2 + (world[:, 0] - shot.x) * near
        up = world[:, 2] - shot.z
        if shot.tilt:
            up = (world[:, 1] - shot.y) * sin(shot.tilt) + up * cos(shot.tilt)
        pixels[:, 1] = self.height / 2 - up * near
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
        """Return the pixels of a length in dm at a point of the space."""
        world = np.asarray(point, float) @ self.frame.rotation.T + self.frame.origin
        return float(length * self.lens.unit(world[:1])[0])


@dataclass(frozen=True)
class View:
    """The spaces of the figure in a pose.

    `head` turns as a solid does. `round` is for the outlines of round things: it moves what is near or far as the head
    turns, and tilts, but never gets narrower.
    """

    body: Space
    head: Space
    round: Space
    legs: Mapping[Leg, Space]
    """They turn as solid ones do, so that steps go where the figure goes."""
    from_behind: bool

    @classmethod
    def of(cls, pose: Pose, lens: Lens, place: Place = HOME) -> "View":
        """The view of a pose at a place.

        A flat figure cannot be walked around: it turns to the side as far as it can, and is `from_behind` beyond that.
        """
        aside = sin(place.th + pi / 2)
        calm = replace(
            pose, head_yaw=pose.head_yaw * _CALM, head_pitch=_CALM * (pose.head_pitch - pose.lean) + pose.lean
        )
        turned_head = replace(calm, head_yaw=calm.head_yaw + _HEAD_ASIDE * aside)
        lower, rise = leg_frames(pose.left_leg, pose.right_leg)
        there = Frame(np.eye(3), np.asarray((place.x * METRE, place.y * METRE, rise)))
        world = standing(place.x * METRE, place.y * METRE, place.th).raised(rise)
        body = body_frame(replace(pose, twist=pose.twist + _BODY_ASIDE * aside)).within(there)
        head = head_frame(turned_head).within(there)
        behind = cos(place.th + pi / 2) < _BEHIND
        if behind:
            body, head = _mirrored(body), _mirrored(head)
        legs = {leg: Space(frame.within(world), lens) for leg, frame in lower.items()}
        return cls(Space(body, lens), Space(head, lens), Space(_rounded(head), lens), legs, behind)


def _mirrored(frame: Frame) -> Frame:
    """The same, with its right side on the left."""
    return Frame(frame.rotation * (-1.0, 1.0, 1.0), frame.origin)


def _rounded(head: Frame) -> Frame:
    tilt = atan2(head.rotation[0, 2], head.rotation[2, 2])
    rotation = head.rotation.copy()
    rotation[:, 0] = (cos(tilt), 0.0, -sin(tilt))
    rotation[:, 2] = (sin(tilt), 0.0, cos(tilt))
    return Frame(rotation, head.origin)
