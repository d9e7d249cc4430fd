"""The stage: figure, backdrop and camera in an off-screen buffer of Panda3D's software renderer."""

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np
from panda3d.core import (
    Camera,
    FrameBufferProperties,
    GraphicsEngine,
    GraphicsOutput,
    GraphicsPipe,
    GraphicsPipeSelection,
    LMatrix4f,
    NodePath,
    PerspectiveLens,
    Texture,
    WindowProperties,
    load_prc_file_data,
)

from openrois_avatar.engines import palette
from openrois_avatar.engines.animation.pose import Pose
from openrois_avatar.engines.panda3d.geometry import Solid
from openrois_avatar.engines.sculpt import figure
from openrois_avatar.engines.sculpt.distance import Array
from openrois_avatar.engines.sculpt.mesh import grid_faces
from openrois_avatar.engines.sculpt.part import Part, Space, State
from openrois_avatar.engines.sculpt.rig import Frame
from openrois_avatar.engines.sculpt.shading import Floats, Lighting, linear
from openrois_avatar.engines.settings import Picture, Pixels

_OVERSAMPLING: Final = 2
"""The buffer is so many times larger than the picture: the renderer itself does not smooth edges."""
_DISTANCE: Final = 15.0
_SPAN: Final = 4.7
"""From the camera to the head, and the height of the picture there, in dm."""
_EYE_LEVEL: Final = -0.66
_SPACES: Final[tuple[Space, ...]] = ("hand_left", "hand_right", "head", "body")
_RELIGHT: Final = 0.004
"""A part is lit anew once it has turned by about so many radians."""

load_prc_file_data(
    "", "load-display p3tinydisplay\nwindow-type offscreen\nsync-video 0\naudio-library-name null\nnotify-level-display error\n"
)


class Stage:
    """Draws the figure; one per process.

    Raises:
        RuntimeError: Panda3D cannot draw here.
    """

    def __init__(self, picture: Picture) -> None:
        cv2.setNumThreads(1)
        self._size = (picture.width, picture.height)
        self._engine = GraphicsEngine.get_global_ptr()
        self._texture = Texture()
        root = NodePath("stage")
        self._buffer = self._opened()
        self._buffer.make_display_region().set_camera(_camera(root, picture.width / picture.height))
        parts = figure.build()
        self._groups = {space: _Group(space, [part for part in parts if part.space == space], root) for space in _SPACES}
        _backdrop(root)
        self._small = np.empty((picture.height, picture.width, 4), np.uint8)
        self._upright = np.empty_like(self._small)

    def draw(self, pose: Pose) -> Pixels:
        """The figure in this pose as BGRA, (height, width, 4), top row first; the next call draws into the same array."""
        frames, visible = figure.frames(pose), figure.visible(pose)
        for space, group in self._groups.items():
            group.show(visible[space])
            if visible[space]:
                group.path.set_mat(_matrix(frames[space]))
                group.update(pose, frames[space].rotation)
        self._engine.render_frame()
        width, height = self._buffer.get_x_size(), self._buffer.get_y_size()
        large = np.frombuffer(self._texture.get_ram_image(), np.uint8).reshape(height, width, 4)
        cv2.resize(large, self._size, dst=self._small, interpolation=cv2.INTER_AREA)
        cv2.flip(self._small, 0, dst=self._upright)
        return self._upright

    def _opened(self) -> GraphicsOutput:
        pipe = GraphicsPipeSelection.get_global_ptr().make_default_pipe()
        if pipe is None:
            raise RuntimeError("Panda3D has no graphics pipe here")
        depth = FrameBufferProperties()
        depth.set_rgba_bits(8, 8, 8, 8)
        depth.set_depth_bits(16)
        size = WindowProperties.size(*(side * _OVERSAMPLING for side in self._size))
        buffer = self._engine.make_output(pipe, "stage", 0, depth, size, GraphicsPipe.BF_refuse_window)
        if buffer is None:
            raise RuntimeError("Panda3D cannot open an off-screen buffer here")
        buffer.add_render_texture(self._texture, GraphicsOutput.RTM_copy_ram)
        buffer.set_clear_color_active(False)
        return buffer


class _Group:
    """Every part of one space as one mesh: what of it changed is made anew, the rest is kept."""

    def __init__(self, space: Space, parts: Sequence[Part], parent: NodePath) -> None:
        shapes = [part.shape(Pose()) for part in parts]
        ends = np.cumsum([len(shape.vertices) for shape in shapes]).tolist()
        starts = [0, *ends[:-1]]
        self._entries = [_Entry(part, slice(start, end)) for part, start, end in zip(parts, starts, ends, strict=True)]
        self._lighting = Lighting([part.surface for part in parts])
        self._vertices, self._normals = np.zeros((ends[-1], 3), np.float32), np.zeros((ends[-1], 3), np.float32)
        self._colours = np.full((ends[-1], 4), 255, np.uint8)
        self._rotation: Floats | None = None
        self.path: NodePath = parent.attach_new_node(space)
        faces = np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)])
        self._solid = Solid(space, self.path, faces, ends[-1])

    def update(self, pose: Pose, rotation: Array) -> None:
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


def _camera(root: NodePath, aspect: float) -> NodePath:
    lens = PerspectiveLens()
    lens.set_fov(*(float(np.degrees(2 * np.arctan(extent / 2 / _DISTANCE))) for extent in (_SPAN * aspect, _SPAN)))
    lens.set_near_far(4.0, 60.0)
    camera = Camera("camera", lens)
    path = root.attach_new_node(camera)
    path.set_pos(0.0, -_DISTANCE, _EYE_LEVEL)
    return path


def _backdrop(root: NodePath) -> None:
    """A soft light on a wall behind the figure; it fills the whole picture, so nothing needs to be cleared."""
    columns, rows = np.linspace(-24, 24, 49), np.linspace(-9, 9, 23)
    z, x = np.meshgrid(rows, columns, indexing="ij")
    vertices = np.stack([x, np.full_like(x, 30.0), z + _EYE_LEVEL], axis=-1).reshape(-1, 3)
    share = 1 - np.exp(-((x / 7.0) ** 2) - ((z - 0.8) / 5.2) ** 2).reshape(-1, 1)
    colours = np.sqrt(linear(palette.BACKDROP_CENTRE)) * (1 - share) + np.sqrt(linear(palette.BACKDROP_EDGE)) * share
    wall = Solid("backdrop", root, grid_faces(len(rows), len(columns), closed=False), len(vertices))
    wall.move(vertices.astype(np.float32))
    wall.paint(np.concatenate([colours * 255, np.full((len(colours), 1), 255.0)], axis=1).astype(np.uint8))


def _matrix(frame: Frame) -> LMatrix4f:
    """Panda's matrices multiply rows from the left."""
    (a, b, c), (d, e, f), (g, h, i) = frame.rotation
    x, y, z = frame.origin
    return LMatrix4f(a, d, g, 0, b, e, h, 0, c, f, i, 0, x, y, z, 1)
