"""Off-screen buffers of Panda3D's software renderer, and how pictures leave them."""

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
    NodePath,
    PerspectiveLens,
    Texture,
    WindowProperties,
    load_prc_file_data,
)

from openrois_avatar.engines.room.shot import DISTANCE, SPAN, Shot
from openrois_avatar.engines.settings import Pixels

_OVERSAMPLING: Final = 3, 2
"""A buffer is larger than its picture by this ratio: the renderer itself does not smooth edges.

Three pixels become two by linear interpolation, which for this ratio nearly is the mean over the area that a pixel
covers, and a sixth of what OpenCV takes for that."""
_OWN: Final = 0.5
"""Tangent of half the angle from the lower edge to the upper of what the figure's own eyes see."""
_NEAR_WALL, _FAR_WALL = 60.0, 160.0
"""Farther than the wall in close views and in others, in dm: depth is the finer the less there is of it."""

load_prc_file_data(
    "",
    "load-display p3tinydisplay\nwindow-type offscreen\nsync-video 0\naudio-library-name null\n"
    "notify-level-display error\nnotify-level-x11display fatal\n",
)


class View:
    """A camera on a scene that draws the middle `columns` of a picture `height` pixels high.

    Raises:
        RuntimeError: Panda3D cannot draw here.
    """

    def __init__(self, scene: NodePath, columns: int, height: int) -> None:
        self._texture = Texture()
        larger, smaller = _OVERSAMPLING
        self._buffer = _opened(columns * larger // smaller, height * larger // smaller)
        self._buffer.add_render_texture(self._texture, GraphicsOutput.RTM_copy_ram)
        self._buffer.set_clear_color((0, 0, 0, 0))
        self._lens = PerspectiveLens()
        self._lens.set_near_far(4.0, _NEAR_WALL)
        self._far, self._own = (_fields(tangent, columns / height) for tangent in (SPAN / 2 / DISTANCE, _OWN))
        self._camera: NodePath = scene.attach_new_node(Camera("camera", self._lens))
        self._buffer.make_display_region().set_camera(self._camera)
        self._shot: Shot | None = None
        self._small = np.empty((height, columns, 4), np.uint8)

    def middle(self, width: int) -> slice:
        """The columns that it draws of a picture of this width."""
        first = (width - self._small.shape[1]) // 2
        return slice(first, first + self._small.shape[1])

    def turn(self, on: bool) -> None:
        """Let Panda3D draw this view with every frame from now on, or not."""
        self._buffer.set_active(on)

    def close(self) -> None:
        """Draw nothing any more."""
        GraphicsEngine.get_global_ptr().remove_window(self._buffer)
        self._camera.remove_node()

    def aim(self, shot: Shot) -> None:
        """Look from there."""
        if shot == self._shot:
            return
        self._shot = shot
        self._lens.set_fov(*(self._own if shot.own else self._far))
        self._lens.set_far(_NEAR_WALL if shot.is_close else _FAR_WALL)
        self._camera.set_pos_hpr(shot.x, shot.y, shot.z, *np.degrees((shot.heading, -shot.tilt)).tolist(), 0.0)

    def read(self) -> Pixels:
        """What was drawn last as BGRA, (height, columns, 4), top row first; a view of an array that is used again."""
        size = (self._small.shape[1], self._small.shape[0])
        cv2.resize(self.read_large(), size, dst=self._small, interpolation=cv2.INTER_LINEAR)
        # Panda3D's rows run from the bottom up.
        return self._small[::-1]

    def read_large(self) -> Pixels:
        """What was drawn last in all its pixels, bottom row first; the next picture changes them."""
        width, height = self._buffer.get_x_size(), self._buffer.get_y_size()
        return np.frombuffer(self._texture.get_ram_image(), np.uint8).reshape(height, width, 4)


def _opened(width: int, height: int) -> GraphicsOutput:
    pipe = GraphicsPipeSelection.get_global_ptr().make_default_pipe()
    if pipe is None:
        raise RuntimeError("Panda3D has no graphics pipe here")
    properties = FrameBufferProperties()
    properties.set_rgba_bits(8, 8, 8, 8)
    properties.set_depth_bits(16)
    engine = GraphicsEngine.get_global_ptr()
    size = WindowProperties.size(width, height)
    buffer = engine.make_output(pipe, "view", 0, properties, size, GraphicsPipe.BF_refuse_window)
    if buffer is None:
        raise RuntimeError("Panda3D cannot open an off-screen buffer here")
    return buffer


def _fields(tangent: float, aspect: float) -> tuple[float, float]:
    """How many degrees a picture covers from side to side and from edge to edge, by half of the latter's tangent."""
    across, along = (float(np.degrees(2 * np.arctan(each))) for each in (tangent * aspect, tangent))
    return across, along
