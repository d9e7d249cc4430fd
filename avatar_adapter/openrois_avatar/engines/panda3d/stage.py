"""The stage: the figure's parts and the backdrop as a scene of Panda3D, drawn pose by pose."""

from collections.abc import Sequence
from itertools import groupby
from typing import Final

import cv2
import numpy as np
from panda3d.core import GraphicsEngine, LMatrix4f, NodePath

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.panda3d.geometry import Solid
from openrois_avatar.engines.panda3d.view import EYE_LEVEL, View
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.sculpt import figure
from openrois_avatar.engines.sculpt.distance import Array
from openrois_avatar.engines.sculpt.mesh import grid_faces
from openrois_avatar.engines.sculpt.part import Part, State
from openrois_avatar.engines.sculpt.rig import Frame
from openrois_avatar.engines.sculpt.shading import Floats, Lighting, linear
from openrois_avatar.engines.settings import Picture, Pixels

_RELIGHT: Final = 0.006
"""A part is lit anew once it has turned by about so many radians."""
_NARROW: Final = 0.90
"""Width, in heights of the picture, of what the figure fills while it keeps its hands down."""


class Stage:
    """Draws the figure; one per process.

    While the hands are down only the middle of the picture is drawn anew: what is beside it does not change.

    Raises:
        RuntimeError: Panda3D cannot draw here.
    """

    def __init__(self, picture: Picture) -> None:
        cv2.setNumThreads(1)
        self._engine = GraphicsEngine.get_global_ptr()
        scene = NodePath("stage")
        columns = min(picture.width, 2 * round(picture.height * _NARROW / 2))
        first = (picture.width - columns) // 2
        self._middle = slice(first, first + columns)
        self._narrow, self._wide = View(scene, columns, picture.height), View(scene, picture.width, picture.height)
        _backdrop(scene)
        self._engine.render_frame()
        self._beside = self._wide.read().copy()
        self._pixels = self._beside.copy()
        self._is_wide = False
        # Nearest first, what never changes its shape apart from what does.
        parts = sorted(figure.build(), key=lambda part: (figure.SPACES.index(part.space), _moves(part)))
        self._groups = [
            _Group(list(group), scene) for _, group in groupby(parts, lambda part: (part.space, _moves(part)))
        ]

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        """The figure in this pose as BGRA, (height, width, 4), top row first; the next call reuses the array."""
        frames, visible = figure.frames(pose), figure.visible(pose)
        for group in self._groups:
            group.show(visible[group.space])
            if visible[group.space]:
                group.update(pose, frames[group.space])
        self._choose(wide=visible["hand_left"] or visible["hand_right"])
        self._engine.render_frame()
        if self._is_wide:
            np.copyto(self._pixels, self._wide.read())
        else:
            np.copyto(self._pixels[:, self._middle], self._narrow.read())
        return self._pixels

    def _choose(self, wide: bool) -> None:
        if self._is_wide and not wide:
            np.copyto(self._pixels, self._beside)
        self._is_wide = wide
        self._wide.turn(wide)
        self._narrow.turn(not wide)


def _moves(part: Part) -> bool:
    return part.state(Pose()) != ()


class _Group:
    """Parts of one space as one mesh: what of it changed is made anew, the rest is kept."""

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

    def update(self, pose: Pose, frame: Frame) -> None:
        """Bring everything that depends on the pose up to date; `frame` is where the space is."""
        self._node.set_mat(_matrix(frame))
        rotation = frame.rotation
        changed = [entry for entry in self._entries if entry.part.state(pose) != entry.state]
        relit = [entry.place for entry in changed if self._reshape(entry, pose)]
        if changed:
            self._solid.move(self._vertices)
        if self._rotation is None or float(np.abs(rotation - self._rotation).max()) > _RELIGHT:
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
        """Whether the part must be lit anew."""
        shape = entry.part.shape(pose)
        entry.state = entry.part.state(pose)
        self._vertices[entry.place] = shape.vertices
        if shape.openness is not None:
            self._lighting.set_openness(entry.place, shape.openness)
        if shape.normals is entry.source:
            return False
        entry.source = shape.normals
        self._normals[entry.place] = shape.normals
        return True


class _Entry:
    """A part's place in its group, and what it looked like last."""

    def __init__(self, part: Part, place: slice) -> None:
        self.part, self.place = part, place
        self.state: State | None = None
        self.source: Array | None = None


def _backdrop(scene: NodePath) -> None:
    """A soft light on a wall behind the figure; it fills the whole picture, so that nothing need be cleared."""
    columns, rows = np.linspace(-24, 24, 49), np.linspace(-9, 9, 23)
    z, x = np.meshgrid(rows, columns, indexing="ij")
    vertices = np.stack([x, np.full_like(x, 30.0), z + EYE_LEVEL], axis=-1).reshape(-1, 3)
    share = 1 - np.exp(-((x / 7.0) ** 2) - ((z - 0.8) / 5.2) ** 2).reshape(-1, 1)
    colours = np.sqrt(linear(palette.BACKDROP_CENTRE)) * (1 - share) + np.sqrt(linear(palette.BACKDROP_EDGE)) * share
    wall = Solid("backdrop", scene, grid_faces(len(rows), len(columns), closed=False), len(vertices))
    wall.move(vertices.astype(np.float32))
    wall.paint(np.concatenate([colours * 255, np.full((len(colours), 1), 255.0)], axis=1).astype(np.uint8))


def _matrix(frame: Frame) -> LMatrix4f:
    """Panda's matrices multiply rows from the left."""
    (a, b, c), (d, e, f), (g, h, i) = frame.rotation
    x, y, z = frame.origin
    return LMatrix4f(a, d, g, 0, b, e, h, 0, c, f, i, 0, x, y, z, 1)
