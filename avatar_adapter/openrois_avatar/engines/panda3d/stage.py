"""The stage: the figure and its room as a scene of Panda3D, drawn pose by pose."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby
from typing import Final

import cv2
import numpy as np
from panda3d.core import GraphicsEngine, NodePath

from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.panda3d.backdrop import Backdrop
from openrois_avatar.engines.panda3d.geometry import Solid, matrix
from openrois_avatar.engines.panda3d.room import Room
from openrois_avatar.engines.panda3d.view import View
from openrois_avatar.engines.room.scene import AT_HOME, Scene
from openrois_avatar.engines.room.shot import HOME_SHOT, METRE, Shot
from openrois_avatar.engines.sculpt import figure
from openrois_avatar.engines.sculpt.distance import Array
from openrois_avatar.engines.sculpt.part import Part, State
from openrois_avatar.engines.sculpt.rig import Frame, standing
from openrois_avatar.engines.sculpt.shading import Floats, Lighting
from openrois_avatar.engines.settings import Picture, Pixels

_RELIGHT: Final = 0.006
_RELIGHT_FAR: Final = 0.05
"""A part is lit anew once it has turned by about so many radians, seen closely and from farther away."""
_NARROW: Final = 0.90
"""Width, in heights of the picture, of what the figure fills while it keeps its hands down."""


class Stage:
    """Draws the figure; one per process.

    Where the figure begins, only the figure is drawn anew, and with calm hands only in the middle of the picture.

    Raises:
        RuntimeError: Panda3D cannot draw here.
    """

    def __init__(self, picture: Picture) -> None:
        cv2.setNumThreads(1)
        self._engine = GraphicsEngine.get_global_ptr()
        scene = NodePath("stage")
        self._figure: NodePath = scene.attach_new_node("figure")
        columns = min(picture.width, 2 * round(picture.height * _NARROW / 2))
        first = (picture.width - columns) // 2
        self._middle = slice(first, first + columns)
        self._narrow, self._wide = View(scene, columns, picture.height), View(scene, picture.width, picture.height)
        self._pixels = np.empty((picture.height, picture.width, 4), np.uint8)
        self._backdrop: Backdrop | None = None
        """What is behind the figure where it begins, once that was drawn."""
        self._is_narrow = False
        """Whether the picture shows the backdrop beside its middle."""
        self._aspect = picture.width / picture.height
        # Nearest first, what never changes its shape apart from what does.
        parts = sorted(figure.build(), key=lambda part: (figure.SPACES.index(part.space), _moves(part)))
        self._groups = [
            _Group(list(group), self._figure) for _, group in groupby(parts, lambda part: (part.space, _moves(part)))
        ]
        self._room = Room(scene)

    def draw(self, pose: Pose, scene: Scene = AT_HOME) -> Pixels:
        """The figure in this pose as BGRA, (height, width, 4), top row first; the next call reuses the array."""
        place, shot = scene.place, scene.shot
        world = standing(place.x * METRE, place.y * METRE, place.th)
        frames, visible = figure.frames(pose, world), figure.visible(pose, whole=not shot.is_close)
        self._show_figure(not shot.own)
        for group in self._groups:
            group.show(visible[group.space])
            if visible[group.space]:
                group.update(pose, frames[group.space], _RELIGHT if shot.is_close else _RELIGHT_FAR)
        company = scene.visitor is not None and shot.sees(scene.visitor.place, self._aspect)
        self._room.update(scene if company else replace(scene, visitor=None))
        if shot != HOME_SHOT or company:
            self._is_narrow = False
            np.copyto(self._pixels, self._drawn(self._wide, shot))
        else:
            hands = visible["hand_left"] or visible["hand_right"]
            self._draw_at_home(narrow=not hands)
        return self._pixels

    def _show_figure(self, visible: bool) -> None:
        if visible:
            self._figure.unstash()
        else:
            self._figure.stash()

    def _drawn(self, view: View, shot: Shot) -> Pixels:
        """What the scene shows; another picture reuses the array."""
        for each in (self._narrow, self._wide):
            each.turn(each is view)
        view.aim(shot)
        self._engine.render_frame()
        return view.read()

    def _draw_at_home(self, narrow: bool) -> None:
        """Draw the figure over a backdrop that was drawn before; where only its middle changes, only that."""
        if self._backdrop is None:
            self._show_figure(False)
            self._backdrop = Backdrop(self._drawn(self._wide, HOME_SHOT))
            self._show_figure(True)
        if narrow and not self._is_narrow:
            self._backdrop.fill(self._pixels)
        self._is_narrow = narrow
        view, columns = (self._narrow, self._middle) if narrow else (self._wide, slice(None))
        self._room.show(False)
        self._backdrop.lay_under(self._drawn(view, HOME_SHOT), columns, self._pixels)
        self._room.show(True)


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

    def update(self, pose: Pose, frame: Frame, relight: float) -> None:
        """Bring everything that depends on the pose up to date.

        `frame` is where the space is; it is lit anew once it has turned by about `relight` radians.
        """
        self._node.set_mat(matrix(frame))
        rotation = frame.rotation
        changed = [entry for entry in self._entries if entry.part.state(pose) != entry.state]
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
