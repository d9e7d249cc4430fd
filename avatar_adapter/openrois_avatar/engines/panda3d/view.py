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

from openrois_avatar.engines.settings import Pixels

_OVERSAMPLING: Final = 2
"""A buffer is so many times larger than its picture: the renderer itself does not smooth edges."""
_DISTANCE: Final = 15.0
_SPAN: Final = 4.7
"""From the camera to the head, and the height of the picture there, in dm."""
EYE_LEVEL: Final = -0.66
"""The camera's height in body space, in dm."""

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
        self._buffer = _opened(columns * _OVERSAMPLING, height * _OVERSAMPLING)
        self._buffer.add_render_texture(self._texture, GraphicsOutput.RTM_copy_ram)
        # The backdrop covers every pixel.
        self._buffer.set_clear_color_active(False)
        self._buffer.make_display_region().set_camera(_camera(scene, columns / height))
        self._small = np.empty((height, columns, 4), np.uint8)

    def turn(self, on: bool) -> None:
        """Let Panda3D draw this view with every frame from now on, or not."""
        self._buffer.set_active(on)

    def read(self) -> Pixels:
        """What was drawn last as BGRA, (height, columns, 4), top row first; a view of an array that is used again."""
        width, height = self._buffer.get_x_size(), self._buffer.get_y_size()
        large = np.frombuffer(self._texture.get_ram_image(), np.uint8).reshape(height, width, 4)
        size = (self._small.shape[1], self._small.shape[0])
        cv2.resize(large, size, dst=self._small, interpolation=cv2.INTER_AREA)
        # Panda3D's rows run from the bottom up.
        return self._small[::-1]


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


def _camera(scene: NodePath, aspect: float) -> NodePath:
    lens = PerspectiveLens()
    lens.set_fov(*(float(np.degrees(2 * np.arctan(extent / 2 / _DISTANCE))) for extent in (_SPAN * aspect, _SPAN)))
    lens.set_near_far(4.0, 60.0)
    path = scene.attach_new_node(Camera("camera", lens))
    path.set_pos(0.0, -_DISTANCE, EYE_LEVEL)
    return path
