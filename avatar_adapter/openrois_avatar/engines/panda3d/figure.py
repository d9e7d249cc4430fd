"""The figure in Panda3D: its parts as one mesh for each space, apart from those with a variable shape."""

from collections.abc import Mapping, Sequence
from itertools import groupby

import numpy as np
from panda3d.core import NodePath

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.figure.figure import SPACES
from openrois_avatar.engines.figure.mesh import Array
from openrois_avatar.engines.figure.part import Part, State
from openrois_avatar.engines.figure.rig import Frame, Space
from openrois_avatar.engines.figure.shading import Floats, Lighting
from openrois_avatar.engines.panda3d.geometry import Solid, matrix, show


class Figure:
    """Parts of a figure under a node of their own."""

    def __init__(self, name: str, parts: Sequence[Part], scene: NodePath) -> None:
        self._node: NodePath = scene.attach_new_node(name)
        # Nearest first, what never changes its shape apart from what does.
        ordered = sorted(parts, key=lambda part: (SPACES.index(part.space), _moves(part)))
        self._groups = [
            _Group(list(group), self._node) for _, group in groupby(ordered, lambda part: (part.space, _moves(part)))
        ]

    def update(self, pose: Pose, frames: Mapping[Space, Frame], visible: Mapping[Space, bool], relight: float) -> None:
        """Update the visible parts; they are lit again once they have turned by about `relight` radians."""
        for group in self._groups:
            group.show(visible[group.space])
            if visible[group.space]:
                group.update(pose, frames[group.space], relight)

    def show(self, on: bool) -> None:
        """Draw it from now on, or do not."""
        show(self._node, on)


def _moves(part: Part) -> bool:
    return part.state(Pose()) != ()


class _Group:
    """Parts of one space as one mesh: only changed parts are updated."""

    def __init__(self, parts: Sequence[Part], scene: NodePath) -> None:
        self.space = parts[0].space
        shapes = [part.shape(Pose()) for part in parts]
        ends = np.cumsum([len(shape.vertices) for shape in shapes]).tolist()
        starts = [0, *ends[:-1]]
        self._entries = [_Entry(part, slice(start, end)) for part, start, end in zip(parts, starts, ends, strict=True)]
        self._lighting = Lighting([part.surface for part in parts])
        self._vertices, self._normals = np.zeros((ends[-1], 3), np.float32), np.zeros((ends[-1], 3), np.float32)
        self._colours = np.full((ends[-1], 4), 255, np.uint8)
        self._rotation: Floats | None = None
        self._node: NodePath = scene.attach_new_node(self.space)
        faces = np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)])
        self._solid = Solid(self.space, self._node, faces, ends[-1])

    def update(self, pose: Pose, frame: Frame, relight: float) -> None:
        """Update everything that depends on the pose.

        `frame` is where the space is; it is lit anew once it has turned by about `relight` radians.
        """
        self._node.set_mat(matrix(frame))
        rotation = frame.rotation
        changed = [entry for entry in self._entries if entry.becomes(entry.part.state(pose))]
        relit = [entry.place for entry in changed if self._reshape(entry, pose)]
        if changed:
            self._solid.move(self._vertices)
        if self._rotation is None or float(np.abs(rotation - self._rotation).max()) > relight:
            self._rotation = rotation.astype(np.float32)
            relit = [slice(None)]
        for place in relit:
            self._colours[place, :3] = self._lighting.colours(place, self._normals[place], self._rotation)
        if relit:
            self._solid.paint(self._colours)

    def show(self, visible: bool) -> None:
        """Draw the group from now on, or do not."""
        self._solid.show(visible)

    def _reshape(self, entry: "_Entry", pose: Pose) -> bool:
        """Return whether the part must be lit again."""
        shape = entry.part.shape(pose)
        self._vertices[entry.place] = shape.vertices
        if shape.openness is not None:
            self._lighting.set_openness(entry.place, shape.openness)
        if shape.normals is entry.source:
            return False
        entry.source = shape.normals
        self._normals[entry.place] = shape.normals
        return True


class _Entry:
    """A part's place in its group, and its last appearance."""

    def __init__(self, part: Part, place: slice) -> None:
        self.part, self.place = part, place
        self.state: State | None = None
        self.source: Array | None = None

    def becomes(self, state: State) -> bool:
        """Note the appearance; return whether it has changed."""
        changed, self.state = state != self.state, state
        return changed
