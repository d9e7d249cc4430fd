"""The faces of the figure that are visible while it stands at its first place: only these are drawn there.

Of 35,000 triangles a viewer sees 9,000: the rest is behind, under the hair, or inside. What is seen is found by drawing
each triangle in a colour of its own, in poses at the edges of what the figure does and between them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import numpy as np
import numpy.typing as npt
from panda3d.core import NodePath

from openrois_avatar.engines.animation.pose import Arm, Mouth, Pose
from openrois_avatar.engines.figure import figure
from openrois_avatar.engines.figure.mesh import Faces
from openrois_avatar.engines.figure.part import Part, cut
from openrois_avatar.engines.panda3d.geometry import Solid, matrix
from openrois_avatar.engines.settings import Pixels

_STIFF: Final = frozenset({"hair", "skull", "ear", "pearl", "neck", "jumper", "sleeve", "band", "collar"})
"""The parts that hardly change their shape."""
_SMILE: Final = 0.30
"""Of a face at rest."""
_CALM: Final = 0.05
"""How far a channel of a calm face may be from that of a face at rest."""
_ARMS: Final = 0.06
"""How far a wrist may be from where it hangs, in dm."""
_HANGING: Final = Arm()
_GLANCE: Final = 0.25
"""How far its eyes turn in its head, in radians, while it is calm."""
_LOOK: Final = 0.65
"""The same for a look at a target, before the head follows."""
_SHAPES: Final = (Mouth(jaw=1.0), Mouth(wide=1.0, jaw=0.5), Mouth(round=1.0, jaw=0.4), Mouth(upper=1.0, lower=1.0))

Kept = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Extent:
    """The extent of the figure's motion in an activity: head and body in radians, and shoulders.

    `calm` is whether its mouth and brows keep still besides; eyes and lids move in any case.
    """

    yaw: float
    pitch: float
    roll: float
    sway: float
    shrug: float
    calm: bool

    def holds(self, pose: Pose) -> bool:
        """Return whether a pose, seen from the front, is within the extent."""
        turns = abs(pose.head_yaw) <= self.yaw and abs(pose.head_pitch) <= self.pitch
        sways = max(abs(pose.twist), abs(pose.side), abs(pose.lean)) <= self.sway and abs(pose.head_roll) <= self.roll
        shrugs = max(pose.shoulder_left, pose.shoulder_right) <= self.shrug
        hangs = _hangs(pose.left) and _hangs(pose.right)
        return turns and sways and shrugs and hangs and (not self.calm or _is_calm(pose))

    def poses(self) -> list[Pose]:
        """Return poses at the edges of the extent and between them."""
        found = []
        edges = product((-self.yaw, -self.yaw / 2, 0.0, self.yaw / 2, self.yaw), (-self.pitch, 0.0, self.pitch))
        for number, (yaw, pitch) in enumerate(edges):
            sign, lid = (-1.0, 0.0, 1.0)[number % 3], (0.0, 0.5, 0.0, 1.0)[number % 4]
            glance = sign * (_GLANCE if self.calm else _LOOK)
            pose = Pose(yaw, pitch, sign * self.roll, glance, -0.6 * glance, lid, lid, breath=number % 2)
            sway, mouth = sign * self.sway, Mouth(smile=_SMILE) if self.calm else _SHAPES[number % len(_SHAPES)]
            found.append(replace(pose, twist=sway, side=-sway, lean=sway, mouth=mouth))
        return [*found, Pose(shoulder_left=self.shrug, shoulder_right=self.shrug, mouth=Mouth(smile=_SMILE))]


AT_REST: Final = Extent(yaw=0.07, pitch=0.04, roll=0.04, sway=0.02, shrug=0.05, calm=True)
ATTENTIVE: Final = Extent(yaw=0.42, pitch=0.28, roll=0.12, sway=0.07, shrug=0.15, calm=False)
"""The extent of looking at a target and speaking."""


def _hangs(arm: Arm) -> bool:
    away = max(abs(arm.out - _HANGING.out), abs(arm.y - _HANGING.y), abs(arm.z - _HANGING.z))
    return away <= _ARMS and abs(arm.swivel - _HANGING.swivel) <= _ARMS


def _is_calm(pose: Pose) -> bool:
    mouth = pose.mouth
    opened = max(mouth.jaw, mouth.wide, mouth.round, mouth.upper, mouth.lower, mouth.press, mouth.bite, mouth.tongue)
    face = max(abs(pose.brow_left), abs(pose.brow_right), pose.frown, pose.squint, pose.wide)
    return (
        max(opened, abs(mouth.smile - _SMILE), face) <= _CALM
        and max(map(abs, (pose.gaze_yaw, pose.gaze_pitch))) <= _GLANCE
    )


def front(parts: Sequence[Part], extent: Extent, scene: NodePath, draw: Callable[[], Pixels]) -> list[Part]:
    """Return the parts without the faces that are invisible from the front within an extent.

    Args:
        parts: the whole figure.
        extent: how far it moves.
        scene: where it is drawn; nothing else is in it meanwhile.
        draw: draws the scene from the front as it is, BGRA, with what is empty transparent.
    """
    shown = [part for part in parts if figure.visible(Pose())[part.space]]
    drawing = _Drawing(shown, scene)
    for pose in extent.poses():
        drawing.note(pose, draw)
    drawing.remove_cards()
    return [
        cut(part, _with_neighbours(part.faces, seen)) if extent.calm or part.name in _STIFF else part
        for part, seen in zip(shown, drawing.seen, strict=True)
        if seen.any()
    ]


class _Drawing:
    """The parts with a colour for each face."""

    def __init__(self, parts: Sequence[Part], scene: NodePath) -> None:
        self._parts = parts
        self.seen = [np.zeros(len(part.faces), np.bool_) for part in parts]
        self._firsts = np.cumsum([1, *(len(part.faces) for part in parts)])
        self._nodes: list[NodePath] = []
        self._solids: list[Solid] = []
        for part, first in zip(parts, self._firsts, strict=False):
            node = scene.attach_new_node(part.name)
            count = 3 * len(part.faces)
            solid = Solid(part.name, node, np.arange(count, dtype=np.int32).reshape(-1, 3), count)
            solid.paint(_colours(np.arange(first, first + len(part.faces))))
            self._nodes.append(node)
            self._solids.append(solid)

    def note(self, pose: Pose, draw: Callable[[], Pixels]) -> None:
        """Note the visible faces in a pose."""
        frames = figure.frames(pose)
        for part, node, solid in zip(self._parts, self._nodes, self._solids, strict=True):
            node.set_mat(matrix(frames[part.space]))
            vertices = part.shape(pose).vertices[part.faces.ravel()]
            solid.move(np.ascontiguousarray(vertices, np.float32))
        numbers = np.zeros(self._firsts[-1], np.bool_)
        numbers[_numbers(draw())] = True
        for seen, first in zip(self.seen, self._firsts, strict=False):
            seen |= numbers[first : first + len(seen)]

    def remove_cards(self) -> None:
        """Remove the cards from the scene."""
        for node in self._nodes:
            node.remove_node()


def _colours(numbers: npt.NDArray[np.int_]) -> npt.NDArray[np.uint8]:
    """Return three vertices of a colour for each number below 65,536; neighbours are a few steps apart."""
    red, green, blue = (numbers & 31) * 8 + 4, (numbers >> 5 & 31) * 8 + 4, (numbers >> 10 & 63) * 4 + 2
    colours = np.stack([red, green, blue, np.full_like(red, 255)], axis=1).astype(np.uint8)
    return np.repeat(colours, 3, axis=0)


def _numbers(pixels: Pixels) -> npt.NDArray[np.int_]:
    """Return the numbers of the visible faces in a picture."""
    blue, green, red = (pixels[..., channel][pixels[..., 3] > 0].astype(np.int_) for channel in range(3))
    return np.unique((red >> 3) | (green >> 3) << 5 | (blue >> 2) << 10)


def _with_neighbours(faces: Faces, seen: Kept) -> Kept:
    """Add the faces that share an edge with a visible one: between two poses they may be visible."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 3, 2).astype(np.int64), axis=2)
    keys = edges[..., 0] * (int(faces.max()) + 1) + edges[..., 1]
    return np.asarray(np.isin(keys, keys[seen]).any(axis=1))
