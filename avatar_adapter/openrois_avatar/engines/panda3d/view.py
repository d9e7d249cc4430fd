"""Off-screen buffers of the software renderer, how pictures leave them, and the still picture laid under them."""

from dataclasses import dataclass
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
from openrois_avatar.engines.settings import Picture, Pixels

_OVERSAMPLING: Final = 3, 2
"""A buffer is larger than its picture by this ratio: the renderer itself does not smooth edges.

Three pixels become two by linear interpolation, which for this ratio nearly is the mean over the area that a pixel
covers, and a sixth of what OpenCV takes for that."""
_LACKING: Final = 0.5
"""The renderer fills a buffer from its first pixel to the middle of its last."""
_OWN: Final = 0.5
"""Tangent of half the angle from the lower edge to the upper of what the figure's own eyes see."""
_NEAR_WALL, _FAR_WALL = 60.0, 160.0
"""Farther than the wall in close views and in others, in dm: depth is the finer the less there is of it."""

load_prc_file_data(
    "",
    "load-display p3tinydisplay\nwindow-type offscreen\nsync-video 0\naudio-library-name null\n"
    "notify-level-display error\nnotify-level-x11display fatal\n",
)


@dataclass(frozen=True, slots=True)
class Area:
    """A part of a picture, in its pixels from the upper left; all are even, so that two areas have no pixel between."""

    left: int
    top: int
    width: int
    height: int

    @property
    def pixels(self) -> tuple[slice, slice]:
        """The rows and columns of an array."""
        return slice(self.top, self.top + self.height), slice(self.left, self.left + self.width)


def middle(picture: Picture, width: float, top: float = 0.0, bottom: float = 1.0) -> Area:
    """The area in the middle of a picture between two levels; all in heights of the picture."""
    first, end = (2 * round(picture.height * level / 2) for level in (top, bottom))
    left = max(0, 2 * round((picture.width - picture.height * width) / 4))
    return Area(left, first, picture.width - 2 * left, end - first)


class View:
    """A camera on a scene that draws an area of a picture.

    Raises:
        RuntimeError: Panda3D cannot draw here.
    """

    def __init__(self, scene: NodePath, picture: Picture, area: Area) -> None:
        self.area = area
        self._texture = Texture()
        left, top, width, height = (_enlarged(each) for each in (area.left, area.top, area.width, area.height))
        whole_width, whole_height = _enlarged(picture.width), _enlarged(picture.height)
        self._buffer = _opened(width, height)
        self._buffer.add_render_texture(self._texture, GraphicsOutput.RTM_copy_ram)
        self._buffer.set_clear_color((0, 0, 0, 0))
        self._lens = PerspectiveLens()
        self._lens.set_near_far(4.0, _NEAR_WALL)
        # As high as the whole picture is one; so every area of it has the same pixels.
        one = whole_height - _LACKING
        self._lens.set_film_size((width - _LACKING) / one, (height - _LACKING) / one)
        self._lens.set_film_offset((left + (width - whole_width) / 2) / one, -(top + (height - whole_height) / 2) / one)
        self._camera: NodePath = scene.attach_new_node(Camera("camera", self._lens))
        self._buffer.make_display_region().set_camera(self._camera)
        self._shot: Shot | None = None
        self.turn(False)
        self._small = np.empty((area.height, area.width, 4), np.uint8)

    def turn(self, on: bool) -> None:
        """Set whether Panda3D draws this view with every frame from now on."""
        self._buffer.set_active(on)

    def close(self) -> None:
        """Stop drawing."""
        GraphicsEngine.get_global_ptr().remove_window(self._buffer)
        self._camera.remove_node()

    def aim(self, shot: Shot) -> None:
        """Set the camera to a shot."""
        if shot == self._shot:
            return
        self._shot = shot
        self._lens.set_focal_length(0.5 / (_OWN if shot.own else SPAN / 2 / DISTANCE))
        self._lens.set_far(_NEAR_WALL if shot.is_close else _FAR_WALL)
        self._camera.set_pos_hpr(shot.x, shot.y, shot.z, *np.degrees((shot.heading, -shot.tilt)).tolist(), 0.0)

    def read(self) -> Pixels:
        """Return the last drawing as BGRA, (height, width, 4), top row first; a view of an array that is used again."""
        size = (self._small.shape[1], self._small.shape[0])
        cv2.resize(self.read_large(), size, dst=self._small, interpolation=cv2.INTER_LINEAR)
        # Panda3D's rows run from the bottom up.
        return self._small[::-1]

    def read_large(self) -> Pixels:
        """Return all pixels of the last drawing, bottom row first; the next picture changes them."""
        width, height = self._buffer.get_x_size(), self._buffer.get_y_size()
        return np.frombuffer(self._texture.get_ram_image(), np.uint8).reshape(height, width, 4)


class Screen:
    """Draws the requested views of a process, and no others."""

    def __init__(self) -> None:
        self._engine = GraphicsEngine.get_global_ptr()
        self._on: tuple[View, ...] = ()

    def draw(self, shot: Shot, *views: View) -> None:
        """Draw these views from there."""
        for view in self._on:
            view.turn(view in views)
        for view in views:
            view.turn(True)
            view.aim(shot)
        self._on = views
        self._engine.render_frame()

    def close(self, *views: View) -> None:
        """Draw these views no more."""
        self._on = tuple(view for view in self._on if view not in views)
        for view in views:
            view.close()


class Backdrop:
    """An area of a picture of the room without the figure, BGRA."""

    def __init__(self, room: Pixels, area: Area) -> None:
        self._area = area.pixels
        # Arrays of their own: OpenCV is several times slower with a part of a wider one.
        self._room = np.ascontiguousarray(room[self._area])
        self._shown = np.empty_like(self._room)
        self._uncovered = np.empty(self._room.shape[:2], np.uint8)

    def lay_under(self, figure: Pixels, picture: Pixels) -> None:
        """Fill this area of `picture` with the room and, before it, a figure that was drawn on nothing.

        `figure` is BGRA, and where it covers a share of a pixel all four are that share of it.
        """
        cv2.bitwise_not(cv2.extractChannel(figure, 3, dst=self._uncovered), dst=self._uncovered)
        cv2.cvtColor(self._uncovered, cv2.COLOR_GRAY2BGRA, dst=self._shown)
        cv2.multiply(self._room, self._shown, dst=self._shown, scale=1 / 255)
        cv2.add(figure, self._shown, dst=picture[self._area])

    def fill(self, picture: Pixels) -> None:
        """Let this area show nothing else."""
        np.copyto(picture[self._area], self._room)


def _enlarged(pixels: int) -> int:
    larger, smaller = _OVERSAMPLING
    return pixels * larger // smaller


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
